"""A look into the simulation while a policy runs: energy, depth in the ground, overlap, support."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.audit.ground import Ground
from robomore.audit.overlap import Overlap
from robomore.envs.measured_env import MeasuredEnv
from robomore.envs.robots.base import Array
from robomore.tasks.task import Task
from robomore.training.rollout import Policy, rollout

_STATE = mujoco.mjtState.mjSTATE_INTEGRATION


@dataclass(frozen=True, slots=True)
class Inspection:
    """What was seen, over all inspected episodes together.

    Attributes:
        motor_work: energy that the motors gave less what they took, in J.
        motor_effort: the sum of what they gave and what they took, in J.
        dissipated: energy lost in the dampers of the joints and in a fluid, in J.
        stored: energy that the robot has at the end and did not have at the start, in J.
        support: fraction of the ground's force that each geom carries, by name.
        depths: for each geom, by name: how deep it goes into the ground at most, in its own radii.
        deep_share: fraction of the time in which some geom is deeper than its own radius.
        usual_depth: of the deepest geom in m, the median of the time in which one is in the ground.
        has_ground: whether the robot is meant to touch a ground at all.
        overlap_share: fraction of the time in which parts overlap whose collision the task switches
            off.
        overlapping: names of the two parts that overlap most often; empty if none do.
        overlap_is_off: whether the task switches any such collision off.
        sprung: energy that soft contacts and joint limits hold at the start, in J. A robot starts
            with noise, a little inside the ground, and the official Ant with its ankles outside
            their range; what pushes it out was there and is not created.
        divergences: episodes in which the physics diverged; no number of energy counts then.
        seconds: simulated time.
    """

    motor_work: float
    motor_effort: float
    dissipated: float
    stored: float
    support: dict[str, float]
    depths: dict[str, float]
    deep_share: float
    usual_depth: float
    has_ground: bool
    overlap_share: float
    overlapping: tuple[str, ...]
    overlap_is_off: bool
    sprung: float
    divergences: int
    seconds: float

    @property
    def created(self) -> float:
        """Energy in J that came from nowhere: stored and dissipated, but not from the motors.

        Contacts and joint limits take energy from a robot, so this is far below zero for a robot
        that runs. Above zero, contacts or the integrator gave some.
        """
        return self.stored + self.dissipated - self.motor_work - self.sprung


def inspect(
    task: Task, parameters: tuple[float, ...], policy: Policy, seeds: Sequence[int]
) -> Inspection:
    """Return what is seen in one episode for each of `seeds`.

    Raises:
        TrainingDiverged, UnstableSimulation: as `robomore.evaluation.measure.measure`.
    """
    env = InspectedEnv(task, parameters, len(seeds))
    rollout(policy, env, seeds)
    return env.seen()


class InspectedEnv(MeasuredEnv):
    """A `MeasuredEnv` whose every substep is looked at. It runs each episode to its end once."""

    def __init__(self, task: Task, parameters: tuple[float, ...], num_envs: int) -> None:
        """Build the simulations; see `VectorEnv`."""
        super().__init__(task, parameters, num_envs)
        model = self.model
        model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
        self._ground = Ground(task, model)
        self._overlap = Overlap(model)
        self._look = mujoco.MjData(model)
        self._state = np.zeros(mujoco.mj_stateSize(model, _STATE))
        self._done = np.zeros(num_envs, np.bool_)
        self._sprung = np.zeros(num_envs)
        self._before = [self._now_at(one) for one in self.data]
        self._start = np.zeros(num_envs)
        self._end_energy = np.zeros(num_envs)
        self._motor_work = np.zeros(num_envs)
        self._motor_effort = np.zeros(num_envs)
        self._dissipated = np.zeros(num_envs)
        self._steps_seen = np.zeros(num_envs, np.int64)

    def seen(self) -> Inspection:
        """Return what was seen in all episodes that ended."""
        seconds = float(self._steps_seen.sum() * self.model.opt.timestep)
        return Inspection(
            motor_work=float(self._motor_work.sum()),
            motor_effort=float(self._motor_effort.sum()),
            dissipated=float(self._dissipated.sum()),
            stored=float((self._end_energy - self._start).sum()),
            support=self._ground.support(),
            depths=self._ground.depths(),
            deep_share=self._ground.deep_share,
            usual_depth=self._ground.usual_depth,
            has_ground=self._ground.exists,
            overlap_share=self._overlap.share,
            overlapping=self._overlap.worst,
            overlap_is_off=self._overlap.is_off,
            sprung=float(self._sprung.sum()),
            divergences=self.divergences,
            seconds=seconds,
        )

    def _begin(self, index: int) -> None:
        super()._begin(index)
        if self._steps_seen[index]:
            return
        self._before[index] = self._now_at(self.data[index])
        self._start[index] = self._energy_now()
        pressed = np.minimum(self._look.efc_pos - self._look.efc_margin, 0.0)
        self._sprung[index] = float(np.abs(self._look.efc_force @ pressed)) / 2

    def _note_substep(self) -> None:
        model = self.model
        timestep = model.opt.timestep
        for index, data in enumerate(self.data):
            if self._done[index]:
                continue
            before, now = self._before[index], self._now_at(data)
            self._before[index] = now
            # A motor's force is the same from step to step, and RK4 moves a joint as it did on
            # average. What the other integrators add to the motion goes by the mean speed.
            travel = timestep * (before.speed + now.speed) / 2
            if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
                moved = now.length - before.length
                # A motor on a site has no length.
                travel = np.where((now.length != 0) | (before.length != 0), moved, travel)
            work = (before.force + now.force) / 2 * travel
            self._motor_work[index] += work.sum()
            self._motor_effort[index] += np.abs(work).sum()
            self._dissipated[index] += timestep * (before.lost + now.lost) / 2
            self._end_energy[index] = self._energy_now()
            self._steps_seen[index] += 1
            self._ground.look(self._look)
            self._overlap.look(self._look)

    def _end(self, ended: NDArray[np.intp], final: Array) -> None:
        super()._end(ended, final)
        self._done[ended] = True

    def _now_at(self, data: mujoco.MjData) -> _Powers:
        """Return forces and powers at the present state.

        After a step, MuJoCo's own numbers are still those from before it.
        """
        model, look = self.model, self._look
        mujoco.mj_getState(model, data, self._state, _STATE)
        mujoco.mj_setState(model, look, self._state, _STATE)
        mujoco.mj_forward(model, look)
        lost = -float((look.qfrc_damper + look.qfrc_fluid) @ look.qvel)
        return _Powers(
            look.actuator_force.copy(),
            look.actuator_velocity.copy(),
            look.actuator_length.copy(),
            lost,
        )

    def _energy_now(self) -> float:
        return float(self._look.energy.sum())


@dataclass(frozen=True, slots=True)
class _Powers:
    """Forces, speeds and lengths of the motors, and the power in W that damping and fluid take."""

    force: Array
    speed: Array
    length: Array
    lost: float
