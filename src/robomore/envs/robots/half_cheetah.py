"""The two-legged Half-Cheetah."""

from __future__ import annotations

from gymnasium.envs.mujoco.half_cheetah_v5 import HalfCheetahEnv

from robomore.envs.robots.base import RobotEnvironment


class HalfCheetahEnvironment(RobotEnvironment, HalfCheetahEnv):
    """HalfCheetah-v5: planar, 6 joints, never terminates."""
