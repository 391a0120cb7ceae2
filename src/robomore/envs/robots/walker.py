"""The two-legged Walker."""

from __future__ import annotations

from gymnasium.envs.mujoco.hopper_v5 import HopperEnv
from gymnasium.envs.mujoco.walker2d_v5 import Walker2dEnv

from robomore.envs.robots.base import UprightEnvironment


class WalkerEnvironment(UprightEnvironment, Walker2dEnv):
    """Walker2d-v5: planar, 6 joints; healthy as the Hopper is, that is with a bounded state too."""

    _healthy_state_range = (-100.0, 100.0)

    is_healthy = HopperEnv.is_healthy
