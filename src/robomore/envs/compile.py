"""From parameters to a MuJoCo model, and the plain facts of the robot in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from robomore.envs import terrain as ground
from robomore.envs.rest_pose import starting_pose
from robomore.errors import InputError, InvalidMorphology
from robomore.tasks.solids import volume_of
from robomore.tasks.task import Task, Terrain

Parameters = Sequence[float] | Mapping[str, float]


def compile_model(task: Task, parameters: Parameters) -> mujoco.MjModel:
    """Return the MuJoCo model of one morphology, on the task's ground.

    Args:
        task: what the robot is for.
        parameters: in the task's order, or by name.

    Raises:
        InvalidMorphology: the task refuses the parameters, or MuJoCo refuses the model.
        InputError: the robot has no motors.
    """
    text = task.mjcf(parameters)
    try:
        spec = mujoco.MjSpec.from_string(text, assets=dict(task.assets))
        model = spec.compile()
        if task.terrain is not None and task.terrain.height:
            # Onto the highest ground beneath it, so that no part starts inside a dune.
            reach = _footprint(model)
            spec.worldbody.first_body().pos[2] += ground.highest(task.terrain, reach)
            model = spec.compile()
            _fill(model, task.terrain)
    except ValueError as error:
        raise InvalidMorphology(f"{task.id}: MuJoCo refuses this morphology: {error}") from error
    if not model.nu:
        raise InputError(
            f"{task.id}: the robot has no motors, so nothing can be learned; add an <actuator> "
            "section to its MJCF, or [[actuator]] tables to its task file"
        )
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
    data.qpos[:] = starting_pose(task, model)
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


def model_volume(model: mujoco.MjModel) -> float:
    """Return the volume in m³ of a compiled robot: the sum over its solids, overlaps counted twice.

    Solids that can touch something count; of a robot that has none of these, all of them.
    """
    robot = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom]]
    solid = [geom for geom in robot if model.geom_contype[geom] or model.geom_conaffinity[geom]]
    return sum(geom_volume(model, geom) for geom in solid or robot)


def geom_volume(model: mujoco.MjModel, geom: int) -> float:
    """Return the volume in m³ of one solid; that of a mesh is what its surface encloses."""
    kind = mujoco.mjtGeom(int(model.geom_type[geom]))
    if kind != mujoco.mjtGeom.mjGEOM_MESH:
        return volume_of(kind.name.removeprefix("mjGEOM_").lower(), model.geom_size[geom].tolist())
    mesh = int(model.geom_dataid[geom])
    start, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    first, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    corners = model.mesh_vert[start : start + count].astype(float)
    a, b, c = (corners[model.mesh_face[first : first + faces, k]] for k in range(3))
    return abs(float((a * np.cross(b, c)).sum()) / 6)


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
