"""From the states of an episode to the `Trajectory` that a fitness is a function of."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.robots.base import Array, RobotEnvironment
from robomore.errors import InputError
from robomore.suggestions import did_you_mean
from robomore.tasks.trajectory import Trajectory

_KINDS = ("body", "site", "geom")
"""What a part may be, in the order in which its name is looked up."""


class Recorder:
    """Knows a robot's root, so that its states become positions and angles.

    Args:
        environment: of the robot.
    """

    def __init__(self, environment: RobotEnvironment) -> None:
        self._environment = environment
        self._model: mujoco.MjModel = environment.model
        self._mass = float(self._model.body_mass[1:].sum())

    def trajectory(
        self,
        states: Array,
        energy: Array,
        contact: NDArray[np.bool_],
        *,
        step_seconds: float,
        full_steps: int,
        fall: str,
    ) -> Trajectory:
        """Return one episode.

        Args:
            states: (T + 1, nq + nv) positions and velocities, the first ones at the start.
            energy: (T,) of the motors in each control step, in J.
            contact: (T,) whether some part touches the ground.
            step_seconds: time of a control step.
            full_steps: control steps of an episode that is not cut short.
            fall: why it ended early; empty if it did not.
        """
        qpos, qvel = states[:, : self._model.nq], states[:, self._model.nq :]
        x, z = self._environment.batch_root(qpos).T
        return Trajectory(
            step_seconds=step_seconds,
            full_steps=full_steps,
            position=np.stack((x, self._sideways(qpos), z), axis=1),
            upright=self._upright(qpos),
            qpos=qpos,
            qvel=qvel,
            energy=energy,
            contact=contact,
            mass=self._mass,
            fall=fall,
            part=partial(_part, self._model, qpos),
        )

    def _sideways(self, qpos: Array) -> Array:
        """Return the root's y (n,) in m, which no planar robot changes."""
        model = self._model
        for joint in self._root_joints():
            first, kind = model.jnt_qposadr[joint], self._kind(joint)
            if kind == mujoco.mjtJoint.mjJNT_FREE:
                return qpos[:, first + 1]
            if kind == mujoco.mjtJoint.mjJNT_SLIDE and abs(model.jnt_axis[joint, 1]) > 0.99:
                moved = (qpos[:, first] - model.qpos0[first]) * model.jnt_axis[joint, 1]
                return np.asarray(model.body_pos[1, 1] + moved)
        return np.full(len(qpos), model.body_pos[1, 1])

    def _upright(self, qpos: Array) -> Array:
        """Return (n,) cosines of the angle by which the root leans away from its rest pose."""
        model, lean = self._model, np.zeros(len(qpos))
        start = self._environment.init_qpos
        for joint in self._root_joints():
            first, kind = int(model.jnt_qposadr[joint]), self._kind(joint)
            if kind in (mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL):
                first += 3 if kind == mujoco.mjtJoint.mjJNT_FREE else 0
                now, rest = qpos[:, first : first + 4], start[first : first + 4]
                return _vertical_cosine(now, rest)
            if kind == mujoco.mjtJoint.mjJNT_HINGE and abs(model.jnt_axis[joint, 2]) < 0.5:
                lean += qpos[:, first] - start[first]
        return np.cos(lean)

    def _kind(self, joint: int) -> mujoco.mjtJoint:
        return mujoco.mjtJoint(int(self._model.jnt_type[joint]))

    def _root_joints(self) -> list[int]:
        first, count = self._model.body_jntadr[1], self._model.body_jntnum[1]
        return list(range(first, first + count))


def _vertical_cosine(now: Array, rest: Array) -> Array:
    """Return (n,) how far the axis that is vertical at `rest` (4,) still is in `now` (n, 4)."""
    inverse, up, turned = np.empty(4), np.empty(3), np.empty(3)
    mujoco.mju_negQuat(inverse, rest)
    mujoco.mju_rotVecQuat(up, np.array([0.0, 0.0, 1.0]), inverse)
    found = np.empty(len(now))
    for row, quaternion in enumerate(now):
        mujoco.mju_rotVecQuat(turned, up, quaternion)
        found[row] = turned[2]
    return found


def _part(model: mujoco.MjModel, qpos: Array, name: str) -> Array:
    """Return the positions (n, 3) in m of a body, site or geom.

    Raises:
        InputError: the robot has no part of that name.
    """
    data = mujoco.MjData(model)
    place = place_of(model, data, name)
    found = np.empty((len(qpos), 3))
    for row, pose in enumerate(qpos):
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        found[row] = place()
    return found


def place_of(model: mujoco.MjModel, data: mujoco.MjData, name: str) -> Callable[[], Array]:
    """Return what gives the live position (3,) in m of a body, site or geom.

    Raises:
        InputError: the robot has no part of that name.
    """
    names: list[str] = []
    for kind in _KINDS:
        count = {"body": model.nbody, "site": model.nsite, "geom": model.ngeom}[kind]
        of_kind = [getattr(model, kind)(index).name for index in range(count)]
        if name in of_kind:
            index = of_kind.index(name)
            positions = data.xpos if kind == "body" else getattr(data, f"{kind}_xpos")
            return lambda: positions[index]
        names += [one for one in of_kind if one and one != "world"]
    hint = did_you_mean(name, names)
    raise InputError(
        f"the robot has no part {name!r}.{hint} It has {', '.join(dict.fromkeys(names))}"
    )
