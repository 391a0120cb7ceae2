"""A picture of what is free in a robot: changed parts in colour and numbered, the rest in grey."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.compile import compile_model
from robomore.errors import InvalidMorphology
from robomore.rendering.drawing import Array, Mark, Scene, draw
from robomore.tasks.task import Parameter, Task

_FIXED = "#b4b2ab"
_CHANGE = 0.1
"""By which a parameter is changed to see what it moves, as a share of its bounds' distance."""


def draw_free(task: Task) -> Scene:
    """Return the picture of a task's reference robot in which all that is free is marked.

    Parameters that change the same solids share a mark. A solid counts as changed if its size is;
    where a parameter changes no size, if its place on its link is, or that link's, or a motor that
    drives it. A count is named with the solids that all of its structures have.

    Raises:
        InvalidMorphology: the task refuses its own reference.
    """
    model = compile_model(task, task.reference)
    scene = draw(task, task.reference)
    names: dict[tuple[int, ...], list[str]] = {}
    for index, parameter in enumerate(task.parameters):
        names.setdefault(_changed(task, model, index), []).append(parameter.name)
    idle = names.pop((), [])
    free = {geom for geoms in names for geom in geoms}
    middles = {one.geom: (one.start + one.end) / 2 for one in scene.strokes}
    strokes = tuple(
        one if one.geom in free else replace(one, colour=_FIXED) for one in scene.strokes
    )
    marks = tuple(
        Mark(tuple(middles[geom] for geom in geoms if geom in middles), ", ".join(parameters))
        for geoms, parameters in names.items()
    )
    if idle:
        marks = (*marks, Mark((), f"{', '.join(idle)}: no part of the reference robot"))
    return replace(scene, strokes=strokes, marks=marks)


def _changed(task: Task, model: mujoco.MjModel, index: int) -> tuple[int, ...]:
    """Return the solids that a parameter changes."""
    for other in _others(task, index):
        if other.ngeom != model.ngeom:
            root = model.body_geomadr[1]
            return (int(root),) if root >= 0 else ()
        moving = model.body_weldid[model.geom_bodyid] != 0
        for facts in (_sizes, _places, _motors):
            found = np.flatnonzero(moving & _differ(facts(model), facts(other)))
            if len(found):
                return tuple(found.tolist())
    return ()


def _others(task: Task, index: int) -> Iterator[mujoco.MjModel]:
    """Yield the robot with one parameter larger, and smaller, as far as that is a robot."""
    for value in _tried(task.parameters[index]):
        values = list(task.reference)
        values[index] = value
        try:
            yield compile_model(task, values)
        except InvalidMorphology:
            continue


def _tried(parameter: Parameter) -> tuple[float, float]:
    step = 1.0 if parameter.whole else _CHANGE * (parameter.high - parameter.low)
    return (
        min(parameter.high, parameter.reference + step),
        max(parameter.low, parameter.reference - step),
    )


def _sizes(model: mujoco.MjModel) -> Array:
    return np.asarray(model.geom_size)


def _places(model: mujoco.MjModel) -> Array:
    links = model.geom_bodyid
    return np.hstack((model.geom_pos, model.geom_quat, model.body_pos[links]))


def _motors(model: mujoco.MjModel) -> Array:
    """Return the strength of the motors of each solid's link, (geoms, 1)."""
    strength = np.zeros(model.nbody)
    for motor in range(model.nu):
        joint = model.actuator_trnid[motor, 0]
        numbers = (
            model.actuator_gear[motor],
            model.actuator_gainprm[motor, :1],
            model.actuator_forcerange[motor],
        )
        strength[model.jnt_bodyid[joint]] += sum(float(np.abs(one).sum()) for one in numbers)
    return strength[model.geom_bodyid, None]


def _differ(ours: Array, theirs: Array) -> NDArray[np.bool_]:
    equal = np.isclose(ours, theirs, rtol=1e-9, atol=1e-12)
    return np.array([not row.all() for row in equal])
