"""Robots at rest as plain numbers: what small pictures in a browser are drawn from."""

from __future__ import annotations

import mujoco

from robomore.envs.compile import Parameters
from robomore.errors import InvalidMorphology
from robomore.rendering.drawing import View, distance_to_world, picture_pose, solids, view_of
from robomore.tasks import Task

Capsules = list[list[float]]
"""Each x, y, z of both ends in m, the radius in m, and how many bodies stand before the world."""


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
        ]
        for one in solids(model, data)
    ]
    return capsules, view_of(model)
