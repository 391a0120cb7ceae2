"""Robots at rest as plain numbers: what small pictures in a browser are drawn from."""

from __future__ import annotations

import mujoco
import numpy as np

from robomore.envs.compile import Parameters
from robomore.errors import InvalidMorphology
from robomore.rendering.drawing import distance_to_world, picture_pose, view_of
from robomore.rendering.outlines import Solid, View, solids
from robomore.tasks import Task

Capsules = list[list[float]]
"""Each x, y, z of both ends in m, the radius in m, and how many bodies stand before the world.

Of a box seven more: half of its sides in m, and its orientation as a quaternion w, x, y, z.
"""


def still(task: Task, parameters: Parameters) -> tuple[Capsules, View]:
    """Return a robot at rest, and where it is best looked at from.

    Raises:
        InvalidMorphology: the task refuses the parameters, or MuJoCo the model.
    """
    text = task.mjcf(parameters)
    try:
        spec = mujoco.MjSpec.from_string(text, assets=dict(task.assets))
        # Generated ground takes longer than all else, and nobody sees it here.
        for geom in list(spec.geoms):
            if geom.type == mujoco.mjtGeom.mjGEOM_HFIELD:
                spec.delete(geom)
        model = spec.compile()
    except ValueError as error:
        raise InvalidMorphology(f"{task.id}: MuJoCo refuses this morphology: {error}") from error
    data = mujoco.MjData(model)
    data.qpos[:] = picture_pose(task, model)
    mujoco.mj_kinematics(model, data)
    capsules = [
        [
            *(round(float(x), 5) for x in (*one.start, *one.end, one.radius)),
            distance_to_world(model, one.body),
            *_box(model, one),
        ]
        for one in solids(model, data)
    ]
    return capsules, view_of(model)


def _box(model: mujoco.MjModel, solid: Solid) -> list[float]:
    """Return what a box has more than a capsule; nothing for another solid."""
    if solid.axes is None:
        return []
    turn = np.zeros(4)
    mujoco.mju_mat2Quat(turn, solid.axes.ravel())
    return [round(float(x), 5) for x in (*model.geom_size[solid.geom], *turn)]
