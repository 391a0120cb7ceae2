"""The solids of a compiled model as plain data: what a browser needs to draw any robot.

Everything comes from the model that MuJoCo compiled, so robots of one's own need no drawing code.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.rendering.drawing import distance_to_world, view_of

_KINDS = {
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: "ellipsoid",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_MESH: "mesh",
}
_HIDDEN_GROUP = 3
"""Geoms of this group and above are not shown by default, as in MuJoCo's own viewer."""
_MOST_FACES = 3000
"""Of one mesh; finer ones are made coarser, so that a page stays small."""


def moving_bodies(model: mujoco.MjModel) -> list[int]:
    """Return the ids of all bodies that are not fixed to the world."""
    return [body for body in range(1, model.nbody) if model.body_weldid[body]]


def shapes(model: mujoco.MjModel) -> dict[str, Any]:
    """Return what stands still and what moves, for `robomore.rendering.packing.pack`.

    Returns:
        `geoms`: kind, size (as in MuJoCo), position and quaternion (w, x, y, z) in the frame of
        `body`, an index into `moving_bodies` or -1 for the world; `depth` counts the bodies
        between it and the world. `meshes`: vertices and triangles. `ground`: heights of horizontal
        planes, and a height field with the places where it lies. `view`: where to look from.
        Lengths in m.
    """
    bodies = {body: index for index, body in enumerate(moving_bodies(model))}
    meshes: dict[int, int] = {}
    geoms = [
        _geom(model, geom, bodies, meshes)
        for geom in _shown(model)
        if int(model.geom_type[geom]) in _KINDS
    ]
    view = view_of(model)
    return {
        "geoms": geoms,
        "meshes": [_mesh(model, mesh) for mesh in meshes],
        "ground": _ground(model),
        "view": {"towards": view.towards.tolist(), "up": view.up.tolist()},
    }


def _shown(model: mujoco.MjModel) -> list[int]:
    visible = [geom for geom in range(model.ngeom) if model.geom_rgba[geom, 3] > 0]
    first = [geom for geom in visible if model.geom_group[geom] < _HIDDEN_GROUP]
    moving = any(model.body_weldid[model.geom_bodyid[geom]] for geom in first)
    return first if moving else visible


def _geom(
    model: mujoco.MjModel, geom: int, bodies: dict[int, int], meshes: dict[int, int]
) -> dict[str, Any]:
    body = int(model.geom_bodyid[geom])
    position, turn = model.geom_pos[geom].copy(), model.geom_quat[geom].copy()
    if body not in bodies:  # fixed, perhaps to a body that is fixed to another
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        position = data.geom_xpos[geom].copy()
        mujoco.mju_mat2Quat(turn, data.geom_xmat[geom])
    found = {
        "kind": _KINDS[int(model.geom_type[geom])],
        "size": _rounded(model.geom_size[geom]),
        "pos": _rounded(position),
        "quat": _rounded(turn),
        "body": bodies.get(body, -1),
        "depth": distance_to_world(model, body),
    }
    if found["kind"] == "mesh":
        mesh = int(model.geom_dataid[geom])
        found["mesh"] = meshes.setdefault(mesh, len(meshes))
    return found


def _mesh(model: mujoco.MjModel, mesh: int) -> dict[str, NDArray[Any]]:
    start, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    vertices = np.array(model.mesh_vert[start : start + count], np.float32)
    start, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    faces = np.array(model.mesh_face[start : start + count], np.uint32)
    cells = 64
    while len(faces) > _MOST_FACES and cells > 2:
        vertices, faces = _coarser(vertices, faces, cells)
        cells = cells * 3 // 4
    return {"vertices": vertices, "faces": faces}


def _coarser(
    vertices: NDArray[np.float32], faces: NDArray[np.uint32], cells: int
) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """Return a mesh with one vertex for each cell of a grid, `cells` along its longest side."""
    low = vertices.min(axis=0)
    step = max(float((vertices.max(axis=0) - low).max()) / cells, 1e-9)
    _, group = np.unique(((vertices - low) / step).astype(np.int64), axis=0, return_inverse=True)
    group = group.ravel()
    sums = np.zeros((group.max() + 1, 3))
    np.add.at(sums, group, vertices)
    middles = sums / np.bincount(group)[:, None]
    merged = group[faces]
    a, b, c = merged.T
    kept = merged[(a != b) & (b != c) & (a != c)]
    return middles.astype(np.float32), kept.astype(np.uint32)


def _ground(model: mujoco.MjModel) -> dict[str, Any]:
    planes, places, field = [], [], -1
    for geom in range(model.ngeom):
        if model.body_weldid[model.geom_bodyid[geom]]:
            continue
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE:
            planes.append(round(float(model.geom_pos[geom, 2]), 5))
        elif model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_HFIELD:
            field = int(model.geom_dataid[geom])
            places.append(_rounded(model.geom_pos[geom]))
    if field < 0:
        return {"planes": planes}
    rows, columns = int(model.hfield_nrow[field]), int(model.hfield_ncol[field])
    start = model.hfield_adr[field]
    heights = model.hfield_data[start : start + rows * columns]
    return {
        "planes": planes,
        "field": {
            "rows": rows,
            "columns": columns,
            "size": _rounded(model.hfield_size[field]),
            "heights": np.round(65535 * np.clip(heights, 0, 1)).astype("<u2"),
            "at": places,
        },
    }


def _rounded(values: NDArray[Any]) -> list[float]:
    return [float(f"{value:.6g}") for value in values]
