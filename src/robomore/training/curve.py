"""The learning curve of a training: recorded as it goes, and checked before it is believed.

A point is kept for each round of training. When there are 64, neighbouring points are merged in
pairs, and from then on a point covers twice as many rounds. No budget enters this, so a continued
training has the curve of one that was never stopped.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.envs.transition import Transition
from robomore.training.trainer import TrainingEnv
from robomore.types import Curve

MOST_POINTS = 64
MOST_TERMS = 64
MOST_SERIES = MOST_TERMS + 16
LONGEST_NAME = 100
"""Bounds of a curve; a name counts its characters."""

_LARGEST_STEP = 2**53

Sums = dict[str, list[float]]
"""Weight and weighted sum of what was seen, by the name of the series."""


class CurveRecorder:
    """Records one training.

    `note_step` is to be called after each control step, `note_round` after each round.
    """

    def __init__(self, num_envs: int) -> None:
        """Begin a curve for a training in `num_envs` environments."""
        self._returns = np.zeros(num_envs)
        self._lengths = np.zeros(num_envs, np.int64)
        self._steps: list[int] = []  # at the end of each point
        self._points: list[Sums] = []
        self._open: Sums = {}  # what the next point holds so far
        self._rounds = 0  # that it covers so far
        self._rounds_per_point = 1
        self._counted: dict[str, list[float]] = {}  # reward sums at the end of the last point

    def note_step(self, transition: Transition) -> None:
        """Count one control step of all environments."""
        self._returns += transition.reward
        self._lengths += 1
        ended = transition.terminated | transition.truncated
        if np.count_nonzero(ended):
            count = int(np.count_nonzero(ended))
            _add(self._open, "episode_return", count, float(self._returns[ended].sum()))
            _add(self._open, "episode_length", count, int(self._lengths[ended].sum()))
            self._returns[ended] = 0
            self._lengths[ended] = 0

    def note_round(self, steps: int, losses: Mapping[str, float], environment: TrainingEnv) -> None:
        """Count one round.

        Args:
            steps: control steps done so far, over all environments.
            losses: means over the round by the name of their series; empty if nothing was learnt.
            environment: is asked for the sums of its reward terms when a point is full.
        """
        for name, value in losses.items():
            _add(self._open, name, 1, value)
        self._rounds += 1
        if self._rounds < self._rounds_per_point:
            return
        sums = environment.reward_sums()
        self._steps.append(steps)
        self._points.append(self._with_terms(sums))
        self._counted = {name: list(pair) for name, pair in sums.items()}
        self._open, self._rounds = {}, 0
        if len(self._points) == MOST_POINTS:
            self._points = [
                _merged(*pair) for pair in zip(self._points[::2], self._points[1::2], strict=True)
            ]
            self._steps = self._steps[1::2]
            self._rounds_per_point *= 2

    def curve(self, steps: int, environment: TrainingEnv) -> Curve:
        """Return the curve after `steps` control steps; a point that is not full stands last."""
        points, ends = self._points, self._steps
        if self._rounds:
            points, ends = [*points, self._with_terms(environment.reward_sums())], [*ends, steps]
        names = sorted({name for point in points for name in point})
        return Curve(
            tuple(ends),
            {name: tuple(_mean(point.get(name)) for point in points) for name in names},
        )

    def state(self) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
        """Return everything needed to continue, as JSON values and as arrays."""
        facts = {
            "steps": self._steps,
            "points": self._points,
            "open": self._open,
            "rounds": self._rounds,
            "rounds_per_point": self._rounds_per_point,
            "counted": self._counted,
        }
        return facts, {"curve_returns": self._returns, "curve_lengths": self._lengths}

    def restore(self, facts: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned."""
        self._steps, self._points, self._open = facts["steps"], facts["points"], facts["open"]
        self._rounds, self._rounds_per_point = facts["rounds"], facts["rounds_per_point"]
        self._counted = facts["counted"]
        self._returns, self._lengths = arrays["curve_returns"], arrays["curve_lengths"]

    def _with_terms(self, sums: Mapping[str, tuple[int, float]]) -> Sums:
        """Return the open point and, in it, the reward terms since the last point."""
        point = {name: list(pair) for name, pair in self._open.items()}
        for name, (count, total) in sums.items():
            count_before, total_before = self._counted.get(name, (0, 0.0))
            series = f"term/{name}"[:LONGEST_NAME]
            _add(point, series, count - count_before, total - total_before)
        return point


def check_curve(curve: Curve) -> None:
    """Refuse a curve that breaks the bounds.

    Raises:
        ValueError: too many points, series or terms, a name that is too long, steps that do not
            rise, a series of another length than the steps, or a value that is not finite.
    """
    steps, series = curve.steps, curve.series
    terms = sum(name.startswith("term/") for name in series)
    if len(steps) > MOST_POINTS or len(series) > MOST_SERIES or terms > MOST_TERMS:
        raise ValueError("the learning curve has too many points or series")
    if any(len(name) > LONGEST_NAME for name in series):
        raise ValueError("the learning curve has a name that is too long")
    if any(not a < b for a, b in zip((0, *steps), (*steps, _LARGEST_STEP), strict=True)):
        raise ValueError("the steps of the learning curve do not rise")
    for name, values in series.items():
        if len(values) != len(steps):
            raise ValueError(f"the series {name!r} of the learning curve has another length")
        if any(value is not None and not math.isfinite(value) for value in values):
            raise ValueError(f"the series {name!r} of the learning curve is not finite")


def _add(sums: Sums, name: str, weight: float, total: float) -> None:
    known = sums.setdefault(name, [0, 0.0])
    known[0] += weight
    known[1] += total


def _merged(first: Sums, second: Sums) -> Sums:
    merged = {name: list(sums) for name, sums in first.items()}
    for name, (weight, total) in second.items():
        _add(merged, name, weight, total)
    return merged


def _mean(sums: list[float] | None) -> float | None:
    if sums is None or not sums[0]:
        return None
    mean = sums[1] / sums[0]
    return mean if math.isfinite(mean) else None
