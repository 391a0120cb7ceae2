"""How far a reward is trusted to run for many simulations at once."""

from __future__ import annotations

import ast
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

FEWEST = 8
"""Simulations below which runs for many are not worth the trouble."""

CHECKS = 32
"""How often each way through a reward is compared with runs per simulation before it is trusted."""

RECHECK = 512
"""A trusted way is compared again every so many runs."""

MOST_WAYS = 256
"""Ways through one reward."""

MOST_STRAYS = 32
"""Runs that may meet numbers that are not finite, each of which is done again per simulation."""

RUN_IN_CALLS = 5
"""What a run for many simulations costs, in calls for one: measured, more for short rewards."""

WINDOW = 64
"""Steps over which runs are counted."""

Way = tuple[Any, tuple[bool, ...]]
"""What a reward kept at the beginning of a run, and the outcomes of its conditions in that run."""


class Trust:
    """Decides, from nothing but what happened, when to compare and when to give up.

    Attributes:
        why: why the reward runs once per simulation; empty while it runs for many at once.
    """

    def __init__(self, n: int, never: str = "") -> None:
        """Start without trust.

        Args:
            n: simulations.
            never: why the reward must not run for many at all.
        """
        self._n = n
        self.why = never if n >= FEWEST or never else f"{n} simulations are too few for a batch"
        self._since = self._steps = self._runs = self._strays = 0
        self._ways: dict[Way, int] = {}

    @property
    def note(self) -> str:
        """How the reward ran."""
        if not self.why:
            return "the reward ran for the whole batch"
        since = f" after {self._since} control steps" if self._since else ""
        return f"the reward ran once per simulation{since}: {self.why}"

    def wants_check(self, way: Way) -> bool:
        """Whether a run that went `way` has to be compared with runs per simulation."""
        count = self._ways.get(way, 0)
        self._ways[way] = count + 1
        if len(self._ways) > MOST_WAYS:
            self.give_up("there are too many ways through it")
        return count < CHECKS or count % RECHECK == 0

    def note_stray(self) -> None:
        """A run met numbers that are not finite, where runs per simulation are right."""
        self._strays += 1
        if self._strays > MOST_STRAYS:
            self.give_up("its numbers are often not finite on the way")

    def note_step(self, runs: int) -> None:
        """A step took some runs."""
        self._runs += runs
        self._steps += 1
        if self._steps % WINDOW == 0:
            if self._runs * RUN_IN_CALLS > WINDOW * self._n:
                self.give_up("its conditions part the simulations too often")
            self._runs = 0

    def give_up(self, why: str) -> None:
        """Run the reward once per simulation from the next step on."""
        if not self.why:
            self.why, self._since = why, self._steps

    def state(self) -> NDArray[np.uint8]:
        """Return everything, as text."""
        content = {
            "why": self.why,
            "counts": [self._since, self._steps, self._runs, self._strays],
            "ways": [[repr(way), count] for way, count in self._ways.items()],
        }
        return np.frombuffer(json.dumps(content).encode(), np.uint8)

    def restore(self, state: NDArray[np.uint8]) -> None:
        """Continue from what `state` returned."""
        content = json.loads(state.tobytes())
        self.why = content["why"]
        self._since, self._steps, self._runs, self._strays = content["counts"]
        self._ways = {ast.literal_eval(way): count for way, count in content["ways"]}
