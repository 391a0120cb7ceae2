"""Many simulations of one morphology, stepped together: what policies are trained and measured on.

The physics runs in a plain loop over MuJoCo's own steps, which is as fast as it gets in one thread
and bit-identical to the official environments. Everything else is done for the whole batch.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.data_fields import REQUESTS
from robomore.envs.gather import Gather, Scatter
from robomore.envs.random_state import generator_state, seed_generator, set_generator_state
from robomore.envs.reward_runner import RewardRunner
from robomore.envs.robots import environment_class
from robomore.envs.robots.base import Array, RewardFunction, all_of_each
from robomore.envs.timestep import without_rk4
from robomore.envs.transition import Transition
from robomore.errors import UnstableSimulation
from robomore.tasks.task import Task
from robomore.types import TermStatistics

_STATE = mujoco.mjtState.mjSTATE_INTEGRATION

DIVERGED = 1e6
"""Positions (m, rad) and velocities (m/s, rad/s) that no robot of ours gets near: MuJoCo warns when
something exceeds 1e10, an acceleration say, which makes a velocity at least so large."""

TOLERATED_DIVERGENCES = 10
"""Divergences that are put up with in any case."""

TOLERATED_SHARE = 0.1
"""Share of episodes that may end in a divergence; with more the morphology cannot be simulated."""


class VectorEnv:
    """`num_envs` simulations of one morphology under one reward (a `TrainingEnv`).

    A simulation whose physics diverges (numbers that are not finite, or beyond `DIVERGED`) ends its
    episode as terminated, in the starting pose. The reward is not called for such a step, which
    gets a reward of 0. Only when that happens again and again does `step` raise.

    Attributes:
        num_envs: environments that are stepped together.
        observation_size: numbers in an observation.
        action_size: motors.
        environment: one Gymnasium environment of this morphology, for options and `batch_` methods.
        data: MuJoCo's data of each simulation.
        observation: (num_envs, observation_size) what the next actions answer to.
        physics_state: (num_envs, nq + nv) positions and velocities now.
        qpos: (num_envs, nq) the positions in it.
        healthy: (num_envs,) bool after the last step.
        diverged: (num_envs,) bool, the physics diverged in the last step.
        divergences: how often it did in all.
        terminates: whether an unhealthy robot ends its episode.
        reward_runner: what calls the reward; `None` without one.
    """

    def __init__(
        self,
        task: Task,
        parameters: Sequence[float] | Mapping[str, float],
        num_envs: int,
        reward: RewardFunction | None = None,
        *,
        auto_reset: bool = True,
        episode_seconds: float | None = None,
        replace_rk4: bool = False,
    ) -> None:
        """Build the simulations; `reset` or `reset_one` has to come before `step`.

        Args:
            task: whose robot this is.
            parameters: of its morphology, in the task's order or by name.
            num_envs: environments that are stepped together.
            reward: called after every step; without one all rewards are 0.
            auto_reset: whether an ended episode is followed by the next one at once. Without it,
                the caller starts episodes with `reset_one`.
            episode_seconds: time after which an episode is cut off, if that is before the task's
                own; `None` for the task's own.
            replace_rk4: whether a task that integrates by RK4 is simulated for half the work
                (`robomore.envs.timestep`).

        Raises:
            InvalidMorphology: the task refuses the parameters, or MuJoCo refuses the model.
        """
        self.environment = environment_class(task)(task, parameters, reward or _no_reward)
        self.model: mujoco.MjModel = self.environment.model
        # A simulation that diverges shows it, instead of starting over in silence.
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        self.num_envs = num_envs
        self.action_size = int(self.model.nu)
        self.observation_size = sum(self.environment.observation_space.shape or ())
        if replace_rk4:
            without_rk4(self.environment)
        self._frame_skip = int(self.environment.frame_skip)
        self._dt = float(self.environment.dt)
        self._steps = task.episode_steps
        if episode_seconds is not None:
            self._steps = min(self._steps, max(1, round(episode_seconds / self._dt)))
        self._auto_reset = auto_reset
        self.terminates = bool(getattr(self.environment, "_terminate_when_unhealthy", False))
        self._falls = self.environment.judges_health()

        self.data = [mujoco.MjData(self.model) for _ in range(num_envs)]
        self._generators = [np.random.Generator(np.random.PCG64(0)) for _ in range(num_envs)]
        self._controls = Scatter([one.ctrl for one in self.data])
        self._control_map = self.environment.control_map()
        self._requested = [
            self.environment.observes_forces,
            False,
        ]  # which of `REQUESTS` each step is to do
        nq, nv = self.model.nq, self.model.nv
        self._rows = Gather(
            [
                [one.qpos, one.qvel] if place is None else [one.qpos, one.qvel, place]
                for one in self.data
                for place in [self.environment.position_view(one)]
            ]
        )
        views = [self.environment.observed_views(one) for one in self.data]
        self._observed = Gather(views) if views[0] else None
        self.physics_state: Array = self._rows.values[:, : nq + nv]
        self.qpos = self.physics_state[:, :nq]
        self._position: Array = self._rows.values[:, -1 if self._rows.width > nq + nv else 0]
        self._more: Array = self._observed.values if self._observed else np.empty((num_envs, 0))

        self._actions: Array = np.zeros((num_envs, self.action_size))
        self.observation: Array = np.zeros((num_envs, self.observation_size))
        self.healthy = np.ones(num_envs, np.bool_)
        self._now = 0  # control steps so far
        self._began = np.zeros(num_envs, np.int64)  # how many there were when each episode began
        self._left = 0  # steps in which surely no episode's time will be up
        self._nowhere = np.zeros(num_envs, np.bool_)
        self._nowhere.flags.writeable = False
        self.diverged: NDArray[np.bool_] = self._nowhere
        self.divergences = 0
        self._episodes = 0
        self._over = np.zeros(num_envs, np.bool_)
        self._last_qpos: Array = self.qpos  # as the last step left it
        self.reward_runner: RewardRunner | None = None
        if reward is not None:
            self.reward_runner = RewardRunner(
                reward, self.environment, self.data, self._generators, self._request
            )

    @property
    def elapsed(self) -> NDArray[np.int64]:
        """(num_envs,) control steps done in each episode."""
        return self._now - self._began

    @property
    def root_positions(self) -> Array:
        """(num_envs, 2) x and z of the torso in m, as the last step left them.

        An episode that starts by itself does not count: after a step that ended an episode these
        are its last positions, after `reset` and `reset_one` the first ones.
        """
        return self.environment.batch_root(self._last_qpos)

    def reset(self, seed: int) -> Array:
        """Start all episodes anew; returns observations (num_envs, observation_size).

        Each simulation draws from a random state that is derived from `seed` and its index. No two
        simulations draw the same, but the first one draws what `numpy.random.default_rng(seed)`
        does, which is where a trainer with that seed draws.
        """
        self.observation = self.observation.copy()  # the last one belongs to the caller
        for index, generator in enumerate(self._generators):
            seed_generator(generator, np.random.SeedSequence([seed, index]))
            self._begin(index)
        self._last_qpos = self.qpos
        return self.observation.copy()

    def reset_one(self, index: int, seed: int) -> Array:
        """Start an episode in simulation `index`; returns its observation (observation_size,).

        It begins as Gymnasium's `reset(seed=seed)` of this robot does.
        """
        self.observation = self.observation.copy()
        seed_generator(self._generators[index], np.random.SeedSequence(seed))
        self._begin(index)
        self._last_qpos[index] = self.qpos[index]
        first: Array = self.observation[index].copy()
        return first

    def step(self, actions: NDArray[np.floating[Any]]) -> Transition:
        """Apply `actions` (num_envs, action_size) in [-1, 1] for one control step.

        Raises:
            RewardFailed: the reward raised or was not a finite number.
            UnstableSimulation: the physics diverged over and over.
        """
        applied: Array = np.array(actions, dtype=np.float64, order="C")
        if applied.shape != (self.num_envs, self.action_size):
            raise ValueError(
                f"actions have the shape {applied.shape}, not {(self.num_envs, self.action_size)}"
            )
        before = self._position.copy()
        self._actions = applied
        self._controls.write(self._control_map.controls(applied))
        self._simulate()
        for compute, requested in zip(REQUESTS, self._requested, strict=True):
            if requested:
                for data in self.data:
                    compute(self.model, data)
        self._gather()
        diverged = self._settle_diverged()

        final = self.environment.batch_observation(self.physics_state, self._more)
        if self._falls:
            self.healthy = self.environment.batch_healthy(self.physics_state)
        terminated = ~self.healthy if self.terminates else np.zeros(self.num_envs, np.bool_)
        if diverged:
            terminated |= self.diverged
        if self.reward_runner is None:
            reward = np.zeros(self.num_envs)
        else:
            x_velocity = (self._position - before) / self._dt
            reward = self.reward_runner(x_velocity, applied, self.healthy, self.diverged)
        self._now += 1
        self._left -= 1
        truncated, ended = np.zeros(self.num_envs, np.bool_), terminated
        may_end = self.terminates or diverged
        if self._left <= 0:
            truncated = self.elapsed >= self._steps
            ended = terminated | truncated
            self._left = self._steps - int(self.elapsed.max())
            may_end = True
        self.observation = final
        self._last_qpos = self.qpos
        if may_end and np.count_nonzero(ended):
            self._end(np.flatnonzero(ended), final)
        return Transition(self.observation, reward, terminated, truncated, final)

    def reward_statistics(self) -> dict[str, TermStatistics]:
        """Return mean, low and high of each reward term over all steps so far."""
        return {} if self.reward_runner is None else self.reward_runner.statistics()

    def reward_sums(self) -> dict[str, tuple[int, float]]:
        """Return, for each reward term, how many finite values it had so far, and their sum."""
        return {} if self.reward_runner is None else self.reward_runner.sums()

    def notes(self) -> tuple[str, ...]:
        """Return facts worth keeping about how these simulations ran."""
        if not self.divergences:
            return ()
        return (f"the physics diverged in {self.divergences} of {self._episodes} episodes",)

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything needed to continue bit-exactly, as arrays.

        Raises:
            RewardFailed: the reward keeps something in `self` that cannot be written down.
        """
        physics = np.empty((self.num_envs, mujoco.mj_stateSize(self.model, _STATE)))
        for data, row in zip(self.data, physics, strict=True):
            mujoco.mj_getState(self.model, data, row, _STATE)
        own = {
            "physics": physics,
            "position": self._position.copy(),
            "observation": self.observation.copy(),
            "elapsed": self.elapsed,
            "over": self._over.copy(),
            "last_qpos": self._last_qpos.copy(),
            "counts": np.array([self.divergences, self._episodes, *self._requested], np.int64),
            "generators": np.stack([generator_state(one) for one in self._generators]),
        }
        runner = {} if self.reward_runner is None else self.reward_runner.state()
        return own | {f"reward_{name}": array for name, array in runner.items()}

    def restore(self, state: dict[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned."""
        for data, row in zip(self.data, state["physics"], strict=True):
            mujoco.mj_resetData(self.model, data)
            mujoco.mj_setState(self.model, data, row, _STATE)
        self._gather()
        # Body positions lag behind qpos within a step, so they cannot be computed from it.
        self._position[:] = state["position"]
        self.observation = state["observation"].copy()
        self._began = self._now - state["elapsed"]
        self._left = 0
        self._over = state["over"].copy()
        self._last_qpos = state["last_qpos"].copy()
        self.divergences, self._episodes = (int(count) for count in state["counts"][:2])
        self._requested = [bool(requested) for requested in state["counts"][2:]]
        for generator, words in zip(self._generators, state["generators"], strict=True):
            set_generator_state(generator, words)
        if self.reward_runner is not None:
            prefix = "reward_"
            self.reward_runner.restore(
                {
                    name.removeprefix(prefix): array
                    for name, array in state.items()
                    if name.startswith(prefix)
                }
            )

    def _simulate(self) -> None:
        model, frame_skip = self.model, self._frame_skip
        for data in self.data:
            mujoco.mj_step(model, data, frame_skip)

    def _gather(self) -> None:
        self._rows.read()
        if self._observed:
            self._observed.read()

    def _request(self, place: int) -> None:
        """Call a function of `REQUESTS` now and after every step from now on."""
        if not self._requested[place]:
            self._requested[place] = True
            for data in self.data:
                REQUESTS[place](self.model, data)

    def _begin(self, index: int) -> None:
        """Start an episode just as the official environment does, with its own code."""
        data, environment = self.data[index], self.environment
        mujoco.mj_resetData(self.model, data)
        environment.data, environment.np_random = data, self._generators[index]
        self.observation[index] = environment.reset_model()
        self._began[index] = self._now
        self._over[index] = False
        self._rows.read_one(index)
        if self.reward_runner is not None:
            self.reward_runner.reset(index)

    def _end(self, ended: NDArray[np.intp], final: Array) -> None:
        self._episodes += int((~self._over[ended]).sum())
        self._over[ended] = True
        if (
            self.divergences > TOLERATED_DIVERGENCES
            and self.divergences > TOLERATED_SHARE * self._episodes
        ):
            raise UnstableSimulation(
                f"The physics diverged in {self.divergences} of {self._episodes} episodes: this "
                "morphology cannot be simulated with these motors."
            )
        if self._auto_reset:
            self._last_qpos = self.qpos.copy()
            self.observation = final.copy()
            for index in ended.tolist():
                self._begin(index)

    def _settle_diverged(self) -> bool:
        """Reset the simulations whose physics diverged; returns whether any did."""
        self.diverged = self._nowhere
        # Not a number is not less than anything.
        if self._rows.square_sum() < DIVERGED**2:
            return False
        self.diverged = ~all_of_each(np.abs(self.physics_state) < DIVERGED)
        for index in np.flatnonzero(self.diverged).tolist():
            self.divergences += int(not self._over[index])
            data = self.data[index]
            mujoco.mj_resetData(self.model, data)
            mujoco.mj_forward(self.model, data)
            for compute, requested in zip(REQUESTS, self._requested, strict=True):
                if requested:
                    compute(self.model, data)
            self._rows.read_one(index)
            if self._observed:
                self._observed.read_one(index)
        return bool(self.diverged.any())


def _no_reward(self: Any, x_velocity: float, action: Array) -> tuple[float, dict[str, float]]:
    return 0.0, {}
