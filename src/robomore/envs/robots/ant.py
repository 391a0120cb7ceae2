"""The four-legged Ant; Ant-Powered, Ant-Desert and Ant-Jump are the same class on other models."""

from __future__ import annotations

from functools import cached_property

import mujoco
import numpy as np
from gymnasium.envs.mujoco.ant_v5 import AntEnv
from numpy.typing import NDArray

from robomore.envs.robots.base import Array, RobotEnvironment, all_of_each, clip_in_place


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

    def observed_views(self, data: mujoco.MjData) -> list[Array]:
        return [data.cfrc_ext.ravel()] if self.observes_forces else []

    def batch_observation(self, state: Array, observed: Array) -> Array:
        if not self.observes_forces:
            return super().batch_observation(state, observed)
        start = self.observation_structure["skipped_qpos"]
        felt = observed[:, 6:]  # nothing pushes the world
        observation = np.concatenate((state[:, start:], felt), axis=1)
        forces = observation[:, -felt.shape[1] :]
        clip_in_place(forces, *self._contact_force_range)
        return observation

    def batch_healthy(self, state: Array) -> NDArray[np.bool_]:
        low, high = self._limits
        return all_of_each(np.logical_and(low <= state, state <= high))

    @cached_property
    def _limits(self) -> Array:
        """(2, nq + nv): what each number of a healthy state stays within; all are finite."""
        largest = np.finfo(np.float64).max
        limits = np.full((2, self.model.nq + self.model.nv), [[-largest], [largest]])
        limits[:, 2] = np.clip(self._healthy_z_range, -largest, largest)
        return limits

    def batch_root(self, qpos: Array) -> Array:
        return qpos[:, [0, 2]]
