"""Trackers: a run's numbers as it goes on, for TensorBoard, Weights & Biases, trackio or yours.

A `Tracker` takes numbers by name. `RunTracking` turns the events of a run into such numbers for one
or several of them. They are optional: no run needs one, and one that fails is left out with a
warning while the run goes on.
"""

from __future__ import annotations

from robomore.trackers.registry import TRACKERS
from robomore.trackers.tracker import Tracked, Tracker
from robomore.trackers.tracking import RunTracking

__all__ = ["TRACKERS", "RunTracking", "Tracked", "Tracker"]
