"""Noise for exploration that is held for some control steps.

Fresh noise at every step cancels out before it moves a heavy limb. How long one draw is held
follows a zeta distribution, as with the temporally extended exploration of Dabney et al. (2021).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

EXPONENT = 2.0
"""A draw is held for k steps with a probability that falls as k to this power."""


class ExplorationNoise:
    """Standard normal noise for each environment.

    Attributes:
        longest: control steps that a draw is held at most; 1 for fresh noise at every step.
    """

    def __init__(self, longest: int, num_envs: int, action_size: int) -> None:
        self.longest = longest
        self._held = np.zeros((num_envs, action_size), np.float32)
        self._left = np.zeros(num_envs, np.int64)

    def draw(self, random: np.random.Generator) -> NDArray[np.float32]:
        """Return the noise (num_envs, action_size) of the next control step."""
        fresh = random.standard_normal(self._held.shape, np.float32)
        if self.longest == 1:
            return fresh
        lengths = np.minimum(random.zipf(EXPONENT, len(fresh)), self.longest)
        due = self._left == 0
        self._held[due] = fresh[due]
        self._left = np.where(due, lengths, self._left) - 1
        return self._held.copy()

    def state(self) -> dict[str, NDArray[Any]]:
        """Return what `restore` needs."""
        return {"noise": self._held, "noise_left": self._left}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on from what `state` returned."""
        self._held, self._left = state["noise"].copy(), state["noise_left"].copy()
