"""One thing changed in the simulation of a robot: what a check runs the policy in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.measured_env import MeasuredEnv
from robomore.envs.timestep import divide_timestep
from robomore.tasks.task import Task
from robomore.training.rollout import Policy
from robomore.transport import GRAVITY

PUSH_EVERY_SECONDS = 2.0
"""A push begins so long after the one before."""
PUSH_SECONDS = 0.1


@dataclass(frozen=True, slots=True)
class Variant:
    """What is changed; the defaults change nothing.

    Attributes:
        timestep_division: MuJoCo's timestep is divided by it; the control step stays.
        integrator: name of `mujoco.mjtIntegrator` without its prefix; empty for the task's own.
        solver: name of `mujoco.mjtSolver` without its prefix; empty for the task's own.
        mass: factor of all masses and inertias of the robot.
        friction: factor of all sliding frictions, the ground's too.
        motors: factor of the force of all motors, and of its limits. A servo's target stays.
        observation_noise: standard deviation of the noise on each observation, as a fraction of
            how far that observation itself spreads.
        action_noise: standard deviation of the noise on each action, of at most 1.
        push: force on the torso in robot weights, against the direction of motion, and sideways in
            turn where the robot can move sideways.
    """

    timestep_division: int = 1
    integrator: str = ""
    solver: str = ""
    mass: float = 1.0
    friction: float = 1.0
    motors: float = 1.0
    observation_noise: float = 0.0
    action_noise: float = 0.0
    push: float = 0.0


PLAIN = Variant()
"""The simulation as it is."""


class VariedEnv(MeasuredEnv):
    """A `MeasuredEnv` in which one thing is changed."""

    def __init__(
        self, task: Task, parameters: tuple[float, ...], num_envs: int, variant: Variant
    ) -> None:
        """Build the simulations; see `VectorEnv`."""
        super().__init__(task, parameters, num_envs)
        model = self.model
        self._push = variant.push * GRAVITY * float(model.body_mass[1:].sum())
        divide_timestep(self.environment, variant.timestep_division)
        self._frame_skip = self.environment.frame_skip
        if variant.integrator:
            model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{variant.integrator}")
        if variant.solver:
            model.opt.solver = getattr(mujoco.mjtSolver, f"mjSOL_{variant.solver}")
        model.body_mass *= variant.mass
        model.body_inertia *= variant.mass
        model.geom_friction[:, 0] *= variant.friction
        _scale_motors(model, variant.motors)
        if variant.mass != 1:
            # What MuJoCo derives from the masses at compilation.
            mujoco.mj_setConst(model, mujoco.MjData(model))

    def _simulate(self) -> None:
        if self._push:
            every = round(PUSH_EVERY_SECONDS / self._dt)
            lasts = max(1, round(PUSH_SECONDS / self._dt))
            for data, elapsed in zip(self.data, self.elapsed.tolist(), strict=True):
                count, since = divmod(elapsed, every)
                pushed = count > 0 and since < lasts
                sideways = self._free and count % 2 == 0
                direction = (0.0, 1.0, 0.0) if sideways else (-1.0, 0.0, 0.0)
                data.xfrc_applied[1, :3] = np.multiply(direction, self._push if pushed else 0.0)
        super()._simulate()


def _scale_motors(model: mujoco.MjModel, factor: float) -> None:
    """Scale what motors give. A gear would turn a servo's target as well."""
    muscle = model.actuator_gaintype == mujoco.mjtGain.mjGAIN_MUSCLE
    numbers = np.arange(mujoco.mjNGAIN)
    # Of a muscle's numbers only these are forces: its largest one, or what that is made from.
    are_forces = ~muscle[:, None] | np.isin(numbers, (2, 3))
    scale = np.where(are_forces, factor, 1.0)
    model.actuator_gainprm *= scale
    model.actuator_biasprm *= scale
    model.actuator_forcerange *= factor
    model.jnt_actfrcrange *= factor
    model.tendon_actfrcrange *= factor


class NoisyPolicy:
    """A policy whose observations and actions are disturbed, the same in each call of an audit."""

    def __init__(
        self, policy: Policy, variant: Variant, spread: NDArray[np.float64], seed: int
    ) -> None:
        """Prepare the noise.

        Args:
            policy: what acts.
            variant: says how much noise.
            spread: (observations,) standard deviation of each observation without noise.
            seed: of the noise.
        """
        self._policy = policy
        self._variant = variant
        self._spread = spread
        self._random = np.random.default_rng(seed)

    def act(self, observations: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
        """Return actions (n, actions) for `observations` (n, observations)."""
        noise = self._random.normal(size=observations.shape) * self._spread
        actions = self._policy.act(observations + self._variant.observation_noise * noise)
        noise = self._random.normal(size=actions.shape)
        disturbed = actions + self._variant.action_noise * noise
        return np.clip(disturbed, -1.0, 1.0).astype(np.float32)


class WatchedPolicy:
    """A policy that notes how far each of its observations spreads."""

    def __init__(self, policy: Policy) -> None:
        self._policy = policy
        self._seen: list[NDArray[np.float64]] = []

    @property
    def spread(self) -> NDArray[np.float64]:
        """(observations,) standard deviation of each observation."""
        spread: NDArray[np.float64] = np.std(np.concatenate(self._seen), axis=0)
        return spread

    def act(self, observations: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
        """Return the policy's actions."""
        self._seen.append(np.array(observations, dtype=np.float64))
        return self._policy.act(observations)
