"""The three-link Swimmer."""

from __future__ import annotations

import numpy as np
from gymnasium.envs.mujoco.swimmer_v5 import SwimmerEnv

from robomore.envs.robots.base import Array, RobotEnvironment


class SwimmerEnvironment(RobotEnvironment, SwimmerEnv):
    """Swimmer-v5: lies in a viscous plane, 2 joints, never terminates."""

    def batch_root(self, qpos: Array) -> Array:
        x, _, z = self.model.body_pos[1]
        return np.stack((qpos[:, 0] + x, np.full(len(qpos), z)), axis=1)
