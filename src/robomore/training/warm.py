"""Compiling once what every candidate of a run would compile again.

What a trainer compiles depends on its settings and on the sizes of observation and action, never
on a design. So a process that runs no untrusted code prepares the trainer once, and leaves what it
compiled in a folder. The candidates' processes then read that folder and may not write to it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import msgspec

from robomore.training.settings import make_trainer
from robomore.types import TrainerSettings


@dataclass(frozen=True, slots=True)
class Shape:
    """What a trainer's compiled code depends on."""

    trainer: TrainerSettings
    observation_size: int
    action_size: int


def warm(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Fill the cache for an encoded `Shape`; runs in a sandboxed process."""
    shape = msgspec.json.decode(payload, type=Shape)
    make_trainer(shape.trainer).prepare(shape.observation_size, shape.action_size)
    return b""
