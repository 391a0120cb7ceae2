"""From parameters to a MuJoCo model, and the plain facts of the robot in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from robomore.envs import terrain as ground
from robomore.errors import InvalidMorphology
from robomore.tasks.task import Task, Terrain

Parameters = Sequence[float] | Mapping[str, float]


def compile_model(task: Task, parameters: Parameters) -> mujoco.MjModel:
    """Return the MuJoCo model of one morphology, on the task's ground.

    Args:
        task: what the robot is for.
        parameters: in the task's order, or by name.

    Raises:
        InvalidMorphology: the task refuses the parameters, or MuJoCo refuses the model.
    """
    text = task.mjcf(parameters)
    try:
        spec = mujoco.MjSpec.from_string(text)
        model = spec.compile()
        if task.terrain is not None and task.terrain.height:
            # Onto the highest ground beneath it, so that no part starts inside a dune.
            reach = _footprint(model)
            spec.worldbody.first_body().pos[2] += ground.highest(task.terrain, reach)
            model = spec.compile()
            _fill(model, task.terrain)
    except ValueError as error:
        raise InvalidMorphology(f"{task.id}: MuJoCo refuses this morphology: {error}") from error
    return model


def body_facts(task: Task, parameters: Parameters) -> dict[str, float]:
    """Return the plain facts of one morphology.

    Returns:
        `volume` in m³ (sum over parts, overlaps counted twice), `mass` in kg, `density` in kg/m³
        (mass / volume, what the robot would have to be made of) and `rest_height` in m (torso above
        the ground beneath it in the initial pose).

    Raises:
        InvalidMorphology: as `compile_model`.
    """
    model = compile_model(task, parameters)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    height = float(data.xpos[1, 2])
    if task.terrain is not None and task.terrain.height:
        height -= ground.highest(task.terrain, _footprint(model))
    mass = float(model.body_mass[1:].sum())
    volume = task.volume(parameters)
    return {
        "volume": volume,
        "mass": mass,
        "density": mass / volume,
        "rest_height": height,
    }


def _footprint(model: mujoco.MjModel) -> float:
    """Return how far the robot reaches sideways from its start in the initial pose, in m."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    robot = model.geom_bodyid > 0
    reach = np.hypot(data.geom_xpos[robot, 0], data.geom_xpos[robot, 1]) + model.geom_rbound[robot]
    return float(reach.max())


def _fill(model: mujoco.MjModel, terrain: Terrain) -> None:
    # After compilation, which would stretch the elevations to the full range from 0 to 1.
    model.hfield_data[:] = ground.tile(terrain).ravel()
