"""Trackers by name. A new one is one file beside this one, and one line here."""

from __future__ import annotations

from robomore.registry import Registry
from robomore.trackers.tracker import Tracker


def _fault(name: str, found: object) -> str:
    methods = ("package", "install", "log", "close")
    missing = [method for method in methods if not hasattr(found, method)]
    return f"has no {', '.join(missing)}" if missing else ""


TRACKERS: Registry[type[Tracker]] = Registry(
    "tracker",
    "robomore.trackers",
    {
        "tensorboard": "robomore.trackers.tensorboard:TensorBoard",
        "wandb": "robomore.trackers.wandb:WeightsAndBiases",
        "trackio": "robomore.trackers.trackio:Trackio",
    },
    _fault,
)
