"""The one-legged Hopper."""

from __future__ import annotations

from gymnasium.envs.mujoco.hopper_v5 import HopperEnv

from robomore.envs.robots.base import UprightEnvironment


class HopperEnvironment(UprightEnvironment, HopperEnv):
    """Hopper-v5: planar, 3 joints."""
