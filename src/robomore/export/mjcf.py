"""A robot and its ground as one MJCF text that MuJoCo loads alone, with nothing beside it.

A task's own text lacks two things: the elevations of a generated ground, which are made from a
seed, and the files of meshes. Both are written into the text. The result is loaded and compared
with the model that was trained before anybody gets it.
"""

from __future__ import annotations

import re
from xml.etree import ElementTree

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.errors import ExportFailed
from robomore.tasks.task import Task

_SAME = (
    "body_mass", "body_inertia", "body_ipos", "body_iquat", "body_pos", "body_quat",
    "body_parentid", "geom_type", "geom_size", "geom_pos", "geom_quat", "geom_friction",
    "geom_bodyid", "geom_contype", "geom_conaffinity", "jnt_type", "jnt_axis", "jnt_pos",
    "jnt_range", "jnt_stiffness", "dof_armature", "dof_damping", "qpos0", "qpos_spring",
    "actuator_gear", "actuator_ctrlrange", "actuator_gainprm", "actuator_biasprm", "mesh_vert",
)  # fmt: skip
"""Arrays of a model that have to be the same."""
_FILE = re.compile(r"\bfile\w*=")
_TOLERANCE = 1e-5
"""Relative. A text of a task's own is loaded to the last bit; elevations and meshes are not."""


def standalone_mjcf(task: Task, parameters: tuple[float, ...], model: mujoco.MjModel) -> str:
    """Return the MJCF text of one morphology.

    Args:
        task: what the robot is for.
        parameters: of its morphology.
        model: compiled from both.

    Raises:
        ExportFailed: MuJoCo makes another model of the text.
    """
    text = task.mjcf(parameters)
    if model.nhfield or _FILE.search(text):
        text = _filled(text, model)
    refuse_other_model(text, model)
    return text


def refuse_other_model(text: str, model: mujoco.MjModel) -> None:
    """Refuse a text that does not give `model` again.

    Raises:
        ExportFailed: naming what differs.
    """
    try:
        again = mujoco.MjModel.from_xml_string(text)
    except ValueError as error:
        raise ExportFailed(f"MuJoCo does not load the exported MJCF: {error}") from None
    before, after = _facts(model), _facts(again)
    for name, mine in before.items():
        theirs = after[name]
        if mine.shape != theirs.shape or not np.allclose(mine, theirs, _TOLERANCE, _TOLERANCE):
            raise ExportFailed(
                f"the exported MJCF gives another model than the one that was trained: {name} "
                "differs; report this with the task's template"
            )


def _facts(model: mujoco.MjModel) -> dict[str, NDArray[np.float64]]:
    facts = {name: np.array(getattr(model, name), np.float64) for name in _SAME}
    # Height is fraction times size, and which of them holds it does not matter.
    facts["geom_size"][model.geom_type == mujoco.mjtGeom.mjGEOM_HFIELD] = 0.0
    cells = model.hfield_nrow * model.hfield_ncol
    facts["elevation"] = model.hfield_data * np.repeat(model.hfield_size[:, 2], cells)
    return facts


def _filled(text: str, model: mujoco.MjModel) -> str:
    """Return the text with everything in it that comes from elsewhere."""
    builder = ElementTree.TreeBuilder(insert_comments=True)
    root = ElementTree.fromstring(text, ElementTree.XMLParser(target=builder))
    for element in root.iter("hfield"):
        _fill_elevations(element, model)
    for element in root.iter("mesh"):
        if element.get("file") is not None:
            _fill_mesh(element, model)
    _drop_pictures(root)
    if model.nhfield:
        # The compiled robot was lifted onto its ground.
        first = next(body for body in root.iter("body"))
        first.set("pos", _numbers(model.body_pos[1]))
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _fill_elevations(element: ElementTree.Element, model: mujoco.MjModel) -> None:
    index = model.hfield(element.get("name")).id
    rows, columns = int(model.hfield_nrow[index]), int(model.hfield_ncol[index])
    start = int(model.hfield_adr[index])
    heights = model.hfield_data[start : start + rows * columns].astype(np.float64)
    # MuJoCo stretches what it reads to the range from 0 to 1; the size takes that back.
    low, high = float(heights.min()), float(heights.max())
    if low:
        raise ExportFailed("the lowest ground is not at height 0, which no MJCF text can say")
    reach_x, reach_y, height, below = model.hfield_size[index].tolist()
    element.set("size", _numbers([reach_x, reach_y, height * (high or 1.0), below]))
    grid = (heights / (high or 1.0)).reshape(rows, columns)
    # The text begins with the row that lies farthest along y, the model with the nearest.
    lines = (" ".join(f"{value:.8g}" for value in row) for row in grid[::-1])
    element.set("elevation", "\n".join(lines))


def _fill_mesh(element: ElementTree.Element, model: mujoco.MjModel) -> None:
    name = element.get("name") or element.get("file", "").rpartition("/")[2].rpartition(".")[0]
    mesh = model.mesh(name).id
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    start, triangles = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    # A compiled mesh lies in the frame of its inertia; this puts it back where it was.
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, model.mesh_quat[mesh])
    vertices = model.mesh_vert[first : first + count] @ matrix.reshape(3, 3).T
    vertices = vertices + model.mesh_pos[mesh]
    for attribute in ("file", "content_type", "scale", "refpos", "refquat"):
        element.attrib.pop(attribute, None)
    element.set("name", name)
    element.set("vertex", _numbers(vertices.ravel()))
    element.set("face", _numbers(model.mesh_face[start : start + triangles].ravel()))


def _drop_pictures(root: ElementTree.Element) -> None:
    """Remove textures that are files: they change nothing but the look."""
    gone = set()
    for asset in root.iter("asset"):
        for texture in list(asset.iter("texture")):
            if any(name.startswith("file") for name in texture.attrib):
                gone.add(texture.get("name"))
                asset.remove(texture)
    for material in root.iter("material"):
        if material.get("texture") in gone:
            material.attrib.pop("texture")


def _numbers(values: object) -> str:
    return " ".join(f"{value:.17g}" for value in np.asarray(values).tolist())
