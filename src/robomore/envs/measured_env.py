"""A `VectorEnv` that also records how a robot moves, what that is worth, and why an episode ended.

Only the trusted process measures with it. Training needs none of this, and does without its cost.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.gather import Gather
from robomore.envs.recorder import Recorder
from robomore.envs.robots.base import Array
from robomore.envs.vector_env import VectorEnv
from robomore.tasks.task import Task
from robomore.tasks.trajectory import Trajectory

SIDE_BY_SIDE = 10
"""Episodes that are measured together; it saves nothing to run more in one thread."""

_AT_LIMIT = 0.99
"""Size of a component of an action from which it counts as at its limit of 1."""

_FEWEST_STEPS = 16
"""Control steps of an episode below which it has no stride worth measuring."""


@dataclass(frozen=True, slots=True)
class Motion:
    """How the robot moved in one episode.

    Attributes:
        energy: mechanical energy of the motors in J: the sum over all of them of the absolute power
            over time. So braking costs as much as driving, and nothing is won back.
        ground_contact: fraction of the control steps in which some part touches the ground.
        stride_frequency: the strongest frequency of the driven hinges, in Hz; 0 if they rest.
        joint_amplitude: amplitude of a driven hinge's angle, the mean over all of them, in rad.
        saturation: fraction of the components of all actions that are at their limit.
        drift: how far the torso moved sideways (along y), in m; `None` for a planar robot.
        turn: how far the torso turned about the vertical axis between start and end, in rad, at
            most pi; `None` for a planar robot.
        fall: why the episode ended early, as a name of `FALLS`; empty if it did not.
        fitness: what the episode is worth, as the task says.
        distance: how far the torso got forward, in m, as far as it counts.
        highest: highest torso height that counts, in m.
    """

    energy: float
    ground_contact: float
    stride_frequency: float
    joint_amplitude: float
    saturation: float
    drift: float | None
    turn: float | None
    fall: str
    fitness: float
    distance: float
    highest: float


FALLS = ("too_low", "too_high", "tilted", "diverged", "unhealthy")
"""Reasons why an episode ends early: the height of the torso, its angle, physics that diverged, or
another rule of the environment."""


class MeasuredEnv(VectorEnv):
    """Simulations without a reward whose episodes are started one by one, by their seeds.

    Attributes:
        motions: of each episode that ended, by its seed.
    """

    def __init__(
        self, task: Task, parameters: Sequence[float] | Mapping[str, float], num_envs: int
    ) -> None:
        """Build the simulations; see `VectorEnv`."""
        super().__init__(task, parameters, num_envs, reward=None, auto_reset=False)
        self.motions: dict[int, Motion] = {}
        model = self.model
        self._power = Gather([[one.actuator_force, one.actuator_velocity] for one in self.data])
        driven = model.actuator_trnid[model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT, 0]
        hinges = driven[model.jnt_type[driven] == mujoco.mjtJoint.mjJNT_HINGE]
        self._angles = model.jnt_qposadr[hinges]
        self._free = bool(model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE)
        self._saturated: Array = np.zeros(num_envs)
        self._on_ground = model.geom_bodyid == 0
        self._seeds = [0] * num_envs
        self._work: Array = np.zeros(num_envs)
        self._states: list[list[Array]] = [[] for _ in range(num_envs)]
        self._energy: list[list[float]] = [[] for _ in range(num_envs)]
        self._touched: list[list[bool]] = [[] for _ in range(num_envs)]
        self._recorder = Recorder(self.environment)
        self._goal = task.goal

    def reset_one(self, index: int, seed: int) -> Array:
        """Start an episode; see `VectorEnv.reset_one`."""
        self._seeds[index] = seed
        return super().reset_one(index, seed)

    def _simulate(self) -> None:
        motors = self.action_size
        self._work[:] = 0.0
        at_limit = np.abs(self._actions) >= _AT_LIMIT
        self._saturated += at_limit.sum(axis=1) / max(1, motors)
        # MuJoCo steps as often as in one call; between the steps, the power is read.
        for _ in range(self._frame_skip):
            for data in self.data:
                mujoco.mj_step(self.model, data)
            self._power.read()
            self._note_substep()
            force, velocity = self._power.values[:, :motors], self._power.values[:, motors:]
            self._work += np.abs(force * velocity).sum(axis=1)
        self._work *= self.model.opt.timestep

    def _note_substep(self) -> None:
        """Look at `data` after each of MuJoCo's own steps; an audit does."""

    def _settle_diverged(self) -> bool:
        diverged = super()._settle_diverged()
        # A step whose physics diverged moves nothing, so it costs nothing either.
        work = np.where(self.diverged, 0.0, self._work).tolist()
        for index, data in enumerate(self.data):
            self._energy[index].append(work[index])
            self._touched[index].append(bool(self._on_ground[data.contact.geom].any()))
            self._states[index].append(self.physics_state[index].copy())
        return diverged

    def _begin(self, index: int) -> None:
        super()._begin(index)
        self._states[index] = [self.physics_state[index].copy()]
        self._energy[index], self._touched[index] = [], []
        self._saturated[index] = 0.0

    def _end(self, ended: NDArray[np.intp], final: Array) -> None:
        for index in ended.tolist():
            # An environment without work goes on idly, with a seed that was measured before.
            if self._seeds[index] not in self.motions:
                self.motions[self._seeds[index]] = self._motion(index)
        super()._end(ended, final)

    def _motion(self, index: int) -> Motion:
        fall = self._fall(index)
        states = np.array(self._states[index])
        energy = np.array(self._energy[index])
        touched = np.array(self._touched[index], dtype=np.bool_)
        trajectory = self._trajectory(states, energy, touched, fall)
        counted = self._trajectory(*_counted(states, energy, touched, fall), fall)
        frequency, amplitude = stride(
            np.ascontiguousarray(trajectory.qpos[1:, self._angles]), self._dt
        )
        drift = turn = None
        if self._free:
            drift = abs(float(trajectory.position[-1, 1] - trajectory.position[0, 1]))
            turn = angle_between(_yaw(trajectory.qpos[-1]), _yaw(trajectory.qpos[0]))
        return Motion(
            energy=trajectory.total_energy,
            ground_contact=float(trajectory.contact.mean()),
            stride_frequency=frequency,
            joint_amplitude=amplitude,
            saturation=float(self._saturated[index] / trajectory.steps),
            drift=drift,
            turn=turn,
            fall=trajectory.fall,
            fitness=self._goal(counted),
            distance=counted.distance,
            highest=float(counted.position[:, 2].max()),
        )

    def _trajectory(
        self, states: Array, energy: Array, touched: NDArray[np.bool_], fall: str
    ) -> Trajectory:
        return self._recorder.trajectory(
            states, energy, touched, step_seconds=self._dt, full_steps=self._steps, fall=fall
        )

    def _fall(self, index: int) -> str:
        """Return why the episode ended early, or an empty text."""
        if self.diverged[index]:
            return "diverged"
        if self.healthy[index] or not self.terminates:
            return ""
        low, high = getattr(self.environment, "_healthy_z_range", (-math.inf, math.inf))
        height = self.environment.batch_root(self.qpos[[index]])[0, 1]
        if height <= low:
            return "too_low"
        if height >= high:
            return "too_high"
        low, high = getattr(self.environment, "_healthy_angle_range", (-math.inf, math.inf))
        tilted = not self._free and not low < self.qpos[index, 2] < high
        # A robot of one's own has no other rules than its height and its tilt.
        tilted |= getattr(self.environment, "_healthy_tilt", None) is not None
        return "tilted" if tilted else "unhealthy"


def _counted(
    states: Array, energy: Array, touched: NDArray[np.bool_], fall: str
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return what counts of an episode's samples: no blow-up, and nothing that leads to one.

    Physics that diverge are seen one step late: a robot may be thrown anywhere before. So of such
    an episode the first sample alone counts, in a step that moves nothing. Of an episode that ends
    since the torso is too high, the sample that ended it does not count.
    """
    steps = {"diverged": 0, "too_high": len(energy) - 1}.get(fall, len(energy))
    if steps == 0:
        return states[[0, 0]], np.zeros(1), touched[:1]
    return states[: steps + 1], energy[:steps], touched[:steps]


def _yaw(qpos: Array) -> float:
    """Return the yaw in rad of a robot with a free joint."""
    a, b, c, d = qpos[3:7].tolist()
    return math.atan2(2 * (a * d + b * c), a * a + b * b - c * c - d * d)


def angle_between(one: float, other: float) -> float:
    """Return the angle between two directions, in rad, from 0 to pi."""
    return abs(math.remainder(one - other, math.tau))


def stride(angles: Array, step_seconds: float) -> tuple[float, float]:
    """Return the strongest frequency in Hz and the mean amplitude in rad of hinge angles.

    Args:
        angles: (control steps, hinges) in rad.
        step_seconds: time of a control step.

    Returns:
        Zeros for an episode that is too short, or in which nothing turns.
    """
    steps = len(angles)
    if steps < _FEWEST_STEPS or not angles.size:
        return 0.0, 0.0
    amplitude = float(np.sqrt(2) * angles.std(axis=0).mean())
    # Of the speeds: a hinge that slowly drifts away has a large amplitude, but makes no strides.
    speeds = np.diff(angles, axis=0)
    spectrum = np.abs(np.fft.rfft(speeds * np.hanning(steps - 1)[:, None], axis=0)) ** 2
    power = spectrum.sum(axis=1)[1:]
    if not power.max() > 0:
        return 0.0, amplitude
    return float((1 + np.argmax(power)) / ((steps - 1) * step_seconds)), amplitude
