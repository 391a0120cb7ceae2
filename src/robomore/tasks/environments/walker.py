"""The two-legged Walker."""

from __future__ import annotations

import numpy as np
from gymnasium.envs.mujoco.walker2d_v5 import Walker2dEnv

from robomore.tasks.environments.base import UprightEnvironment


class WalkerEnvironment(UprightEnvironment, Walker2dEnv):
    """Walker2d-v5: planar, 6 joints; healthy as the Hopper is, that is with a bounded state too."""

    _healthy_state_range = (-100.0, 100.0)

    @property
    def is_healthy(self) -> bool:
        """Whether an episode may go on: upright, and no velocity or angle has run away."""
        low, high = self._healthy_state_range
        state = self.state_vector()[2:]
        return bool(np.all((low < state) & (state < high))) and bool(super().is_healthy)
