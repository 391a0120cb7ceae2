"""The four-legged Ant; Ant-Powered, Ant-Desert and Ant-Jump are the same class on other models."""

from __future__ import annotations

import mujoco
import numpy as np
from gymnasium.envs.mujoco.ant_v5 import AntEnv
from numpy.typing import NDArray

from robomore.tasks.environments.base import Array, RobotEnvironment


class AntEnvironment(RobotEnvironment, AntEnv):
    """Ant-v5: a free body, 8 joints, contact forces in the observation."""

    def position_view(self, data: mujoco.MjData) -> Array:
        # MuJoCo computes body positions before a step's last update of qpos, and the official class
        # measures the velocity with those.
        view: Array = data.body(self._main_body).xpos[:1]
        return view

    @property
    def observes_forces(self) -> bool:
        return bool(self._include_cfrc_ext_in_observation)

    def batch_observation(self, qpos: Array, qvel: Array, cfrc_ext: Array) -> Array:
        state = super().batch_observation(qpos, qvel, cfrc_ext)
        if not self.observes_forces:
            return state
        # The world body feels no force worth observing.
        forces = np.clip(cfrc_ext[:, 1:], *self._contact_force_range)
        return np.concatenate((state, forces.reshape(len(qpos), -1)), axis=1)

    def batch_healthy(self, qpos: Array, qvel: Array) -> NDArray[np.bool_]:
        low, high = self._healthy_z_range
        height = qpos[:, 2]
        finite = np.isfinite(qpos).all(axis=1) & np.isfinite(qvel).all(axis=1)
        return finite & (low <= height) & (height <= high)

    def batch_root(self, qpos: Array) -> Array:
        return qpos[:, [0, 2]]
