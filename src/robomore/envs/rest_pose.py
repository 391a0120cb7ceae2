"""The pose in which an episode starts, before any noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.tasks.task import Task

Array = NDArray[np.float64]

CLEARANCE = 0.003
"""Height in m above the floor of the lowest point at the start."""

_FLOOR = "floor"


def starting_pose(task: Task, model: mujoco.MjModel) -> Array:
    """Return qpos (nq,) of a task's robot at rest: the model's own, or that of its options."""
    options = task.options(dict(zip(task.names, task.reference, strict=True)))
    if "upright" not in options:
        return np.array(model.qpos0)
    return rest_pose(model, options["home"], options["upright"])


def rest_pose(model: mujoco.MjModel, home: Mapping[str, float], upright: Sequence[float]) -> Array:
    """Return qpos (nq,) at rest; the lowest point of a free robot is just above the floor.

    Args:
        model: of the robot.
        home: angle (rad) or position (m) by joint; others are as the model has them.
        upright: orientation of a free root, as a quaternion w, x, y, z.
    """
    pose: Array = np.array(model.qpos0)
    for number in range(model.njnt):
        if (value := home.get(model.joint(number).name)) is not None:
            pose[model.jnt_qposadr[number]] = value
    if not (model.njnt and model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE):
        return pose
    pose[:3], pose[3:7] = 0.0, upright
    data = mujoco.MjData(model)
    data.qpos[:] = pose
    mujoco.mj_forward(model, data)
    pose[2] = CLEARANCE - lowest_point(model, data)
    return pose


def lowest_point(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """Return the distance in m between the floor and the robot's lowest solid; below 0 if deeper.

    Links that cannot touch the floor do not count, unless none can.
    """
    floor = model.geom(_FLOOR).id
    robot = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom]]
    solid = [g for g in robot if model.geom_contype[g] or model.geom_conaffinity[g]] or robot
    distances = (mujoco.mj_geomDistance(model, data, floor, geom, 1e3, None) for geom in solid)
    return float(min(distances))
