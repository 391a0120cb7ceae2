"""What the robots share: a model from a template, a reward from outside, `batch_` methods."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

import mujoco
import numpy as np
from gymnasium.envs.mujoco import MujocoEnv
from gymnasium.spaces import Box
from gymnasium.utils import EzPickle
from numpy.typing import NDArray

from robomore.envs.compile import compile_model
from robomore.envs.control_map import ControlMap
from robomore.envs.opengl import ensure_opengl, ensure_screen
from robomore.tasks.task import Task

Array = NDArray[np.float64]

RewardFunction = Callable[[Any, float, Array], tuple[float, Mapping[str, float]]]
"""`_get_rew(self, x_velocity, action) -> (reward, terms)`, as the official classes spell it."""


class RobotEnvironment(MujocoEnv):
    """Stands before an official v5 class: `class HopperEnvironment(RobotEnvironment, HopperEnv)`.

    Methods that start with `batch_` are the same facts for many simulations at once; they depend on
    the constructor's options and on their arguments alone.
    """

    # Set by the official constructors.
    observation_structure: dict[str, int]

    def __init__(
        self,
        task: Task,
        parameters: Sequence[float] | Mapping[str, float],
        reward: RewardFunction,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        """Build the robot.

        Args:
            task: whose robot this is.
            parameters: of its morphology, in the task's order or by name.
            reward: called as `reward(self, x_velocity, action)` after every control step.
            render_mode: as in Gymnasium.
            options: of the official class, over those of the task (`reset_noise_scale=…`).

        Raises:
            InvalidMorphology: the task refuses the parameters.
        """
        self._task = task
        self._parameters = task.check(parameters)
        self._reward = reward
        self._reward_attributes: set[str] = set()
        self._reward_calls = 0
        self._control_map: ControlMap | None = None
        chosen = {**task.options(task.named(self._parameters)), **options}
        super().__init__(render_mode=render_mode, **chosen)
        # The official constructor has noted its own arguments for pickling; these are ours.
        arguments = (task, self._parameters, reward, render_mode)
        EzPickle.__init__(self, *arguments, **options)  # type: ignore[arg-type]  # official mix-in

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start an episode; whatever the reward kept in `self` is forgotten."""
        for name in self._reward_attributes:
            vars(self).pop(name, None)
        self._reward_attributes.clear()
        observation: Array
        observation, info = super().reset(seed=seed, options=options)
        return observation, info

    def render(self) -> Any:
        """Return a picture, or show it, as Gymnasium says of `render_mode`.

        Raises:
            InputError: there is no OpenGL that works here, or no screen to show it on.
        """
        if self.render_mode == "human":
            ensure_screen()
        elif self.render_mode is not None:
            ensure_opengl()
        return super().render()  # type: ignore[no-untyped-call]  # Gymnasium's own

    def position_view(self, data: mujoco.MjData) -> Array | None:
        """Return a live view (1,) of the x position whose change is the x-velocity, in m.

        `None` if that is the first number of `qpos`.
        """
        return None

    def do_simulation(self, ctrl: Array, n_frames: int) -> None:
        """Apply an action in [-1, 1] for some steps of MuJoCo; the robots' own `step` calls it."""
        if self._control_map is None:
            self._control_map = self.control_map()
        controls = self._control_map.controls(np.asarray(ctrl, dtype=np.float64))
        super().do_simulation(controls, n_frames)

    def control_map(self) -> ControlMap:
        """Return where actions go on the motors' control ranges."""
        return ControlMap(self.model, self.init_qpos)

    @property
    def training_steps(self) -> int:
        """Control steps done so far, over all episodes and all simulations of a training."""
        return self._reward_calls

    @property
    def observes_forces(self) -> bool:
        """Whether observations need the contact forces (`cfrc_ext`)."""
        return False

    def observed_views(self, data: mujoco.MjData) -> list[Array]:
        """Return live flat views of what observations hold besides positions and velocities."""
        return []

    def batch_observation(self, state: Array, observed: Array) -> Array:
        """Return observations (num_envs, observation size) as a new array.

        Args:
            state: (num_envs, nq + nv) positions and velocities.
            observed: (num_envs, …) the `observed_views` side by side.
        """
        return state[:, self.observation_structure["skipped_qpos"] :].copy()

    def batch_healthy(self, state: Array) -> NDArray[np.bool_]:
        """Return (num_envs,) bool: whether episodes may go on from `state` (num_envs, nq + nv)."""
        return np.ones(len(state), dtype=np.bool_)

    @classmethod
    def judges_health(cls) -> bool:
        """Whether `batch_healthy` looks at the state at all."""
        return cls.batch_healthy is not RobotEnvironment.batch_healthy

    def batch_root(self, qpos: Array) -> Array:
        """Return (num_envs, 2): x and z of the torso, in m."""
        # Slide joints count from the pose in which the model was written down.
        origin: Array = self.model.body_pos[1, [0, 2]] - self.model.qpos0[:2]
        return qpos[:, :2] + origin

    def _set_action_space(self) -> Box:
        self.action_space = Box(-1.0, 1.0, (int(self.model.nu),), np.float32)
        return self.action_space

    def _initialize_simulation(self) -> tuple[mujoco.MjModel, mujoco.MjData]:
        model = compile_model(self._task, self._parameters)
        screen = model.vis.global_
        screen.offwidth = max(screen.offwidth, self.width)
        screen.offheight = max(screen.offheight, self.height)
        return model, mujoco.MjData(model)

    def _get_rew(self, x_velocity: float, action: Array) -> tuple[float, Mapping[str, float]]:
        # What a step leaves out; the official step computes the forces.
        mujoco.mj_subtreeVel(self.model, self.data)
        mujoco.mj_energyPos(self.model, self.data)
        mujoco.mj_energyVel(self.model, self.data)
        known = set(vars(self))
        result = self._reward(self, x_velocity, action)
        self._reward_calls += 1
        self._reward_attributes |= vars(self).keys() - known
        return result


class UprightEnvironment(RobotEnvironment):
    """Hopper and Walker: planar, healthy while upright, velocities clipped in the observation."""

    # Set by the official constructors.
    _healthy_state_range: tuple[float, float]
    _healthy_z_range: tuple[float, float]
    _healthy_angle_range: tuple[float, float]

    def batch_observation(self, state: Array, observed: Array) -> Array:
        observation = super().batch_observation(state, observed)
        velocities = observation[:, -self.model.nv :]
        clip_in_place(velocities, -10, 10)
        return observation

    def batch_healthy(self, state: Array) -> NDArray[np.bool_]:
        low, high = self._limits
        return all_of_each(np.logical_and(low < state, state < high))

    @cached_property
    def _limits(self) -> Array:
        """(2, nq + nv): what each number of a healthy state stays between; x is free."""
        limits = np.empty((2, self.model.nq + self.model.nv))
        limits[:, 0] = -np.inf, np.inf
        limits[:, 1] = self._healthy_z_range
        limits[:, 2:] = np.reshape(self._healthy_state_range, (2, 1))
        low, high = self._healthy_angle_range
        limits[:, 2] = max(limits[0, 2], low), min(limits[1, 2], high)
        return limits


def clip_in_place(values: Array, low: float, high: float) -> None:
    """Keep `values` within limits; on small arrays several times faster than `np.clip`."""
    np.maximum(values, low, out=values)
    np.minimum(values, high, out=values)


def all_of_each(rows: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (num_envs,) whether all of a row are true; faster than `rows.all(axis=1)`."""
    every: NDArray[np.bool_] = np.logical_and.reduce(rows, axis=1)
    return every
