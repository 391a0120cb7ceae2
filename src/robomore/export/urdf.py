"""A compiled robot as URDF, written by ourselves: public converters lose capsules.

URDF knows no capsule, so each is kept as a cylinder with a ball at each end. A body that several
joints connect becomes a chain of links, all but the last without mass. Joint positions are zero in
the pose in which the model was written down.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from itertools import combinations_with_replacement
from xml.etree import ElementTree

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.motor_force import joint_force
from robomore.export.stl import stl_bytes

Array = NDArray[np.float64]

NO_LIMIT = 1e6
"""Stands where URDF requires a limit that the model does not have: m, rad/s, m/s, N or Nm."""

MESHES = "meshes"
"""Folder of meshes beside the URDF file."""

_JOINT, _GEOM = mujoco.mjtJoint, mujoco.mjtGeom


def write_urdf(model: mujoco.MjModel, name: str) -> tuple[str, dict[str, bytes]]:
    """Return a robot as URDF text, and the meshes that it refers to by their file names.

    Args:
        model: of the robot; whatever belongs to the world is left out.
        name: of the robot.
    """
    return _Writer(model, name).write()


def lost_in_urdf(model: mujoco.MjModel) -> list[str]:
    """Return what the model has and URDF cannot say, in words."""
    # A free joint has no rotor and no spring that anybody set.
    lost = [
        ("the rotors' inertia (armature)", bool(model.dof_armature.any())),
        ("springs of joints", bool(model.jnt_stiffness.any())),
        ("gears and signals of motors, but for their largest force", bool(model.nu)),
        ("friction and softness of contacts", True),
        ("the ground and whatever stands on it", bool((model.geom_bodyid == 0).any())),
        ("the fluid that the robot moves in", bool(model.opt.density or model.opt.viscosity)),
        ("tendons", bool(model.ntendon)),
        ("equality constraints", bool(model.neq)),
        ("ball joints, which became three hinges each", _has(model, _JOINT.mjJNT_BALL)),
    ]
    return [words for words, there in lost if there]


def link_names(model: mujoco.MjModel) -> list[str]:
    """Return the name of each body's link, each another one; the world is `world`."""
    return _unique(["world", *(model.body(i).name or f"body_{i}" for i in range(1, model.nbody))])


def joint_names(model: mujoco.MjModel) -> list[str]:
    """Return the name of each joint, each another one."""
    return _unique([model.joint(i).name or f"joint_{i}" for i in range(model.njnt)])


class _Writer:
    def __init__(self, model: mujoco.MjModel, name: str) -> None:
        self.model = model
        self.root = ElementTree.Element("robot", name=name)
        self.links, self.joints = link_names(model), joint_names(model)
        self.meshes: dict[str, bytes] = {}
        # A link's frame lies at its last joint, which a body's frame need not do.
        self.offsets = np.zeros((model.nbody, 3))
        self.data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, self.data)

    def write(self) -> tuple[str, dict[str, bytes]]:
        ElementTree.SubElement(self.root, "link", name=self.links[0])
        for body in range(1, self.model.nbody):
            if self.model.body_weldid[body]:
                self._body(body)
        ElementTree.indent(self.root)
        text = ElementTree.tostring(self.root, encoding="unicode")
        return f'<?xml version="1.0"?>\n{text}\n', self.meshes

    def _body(self, body: int) -> None:
        model = self.model
        parent = int(model.body_parentid[body])
        position, rotation = model.body_pos[body], _matrix(model.body_quat[body])
        if not model.body_weldid[parent]:
            # Bodies that do not move are part of the world.
            outer = self.data.xmat[parent].reshape(3, 3)
            position, rotation = self.data.xpos[parent] + outer @ position, outer @ rotation
            above = self.links[0]
        else:
            position, above = position - self.offsets[parent], self.links[parent]
        steps = list(self._steps(body))
        anchor = np.zeros(3)
        for index, (name, kind, axis, joint) in enumerate(steps):
            here = model.jnt_pos[joint] if joint >= 0 and kind != "floating" else np.zeros(3)
            last = index == len(steps) - 1
            below = self.links[body] if last else f"{self.links[body]}__{name}"
            element = ElementTree.SubElement(self.root, "joint", name=name, type=kind)
            shift, turn = (rotation @ here, rotation) if not index else (here - anchor, np.eye(3))
            _origin(element, position + shift if not index else shift, turn)
            ElementTree.SubElement(element, "parent", link=above)
            ElementTree.SubElement(element, "child", link=below)
            if axis is not None:
                ElementTree.SubElement(element, "axis", xyz=_text(axis))
                self._dynamics(element, kind, joint)
            if not last:
                ElementTree.SubElement(self.root, "link", name=below)
            above, anchor = below, here
        self.offsets[body] = anchor
        self._link(body)

    def _steps(self, body: int) -> Iterator[tuple[str, str, Array | None, int]]:
        """Yield (name, kind, axis, joint) of each joint between a body and what carries it."""
        model = self.model
        first = int(model.body_jntadr[body])
        if first < 0:
            yield f"{self.links[body]}__fixed", "fixed", None, -1
        for joint in range(first, first + int(model.body_jntnum[body])):
            name, kind = self.joints[joint], int(model.jnt_type[joint])
            if kind == _JOINT.mjJNT_FREE:
                yield name, "floating", None, joint
            elif kind == _JOINT.mjJNT_BALL:
                for axis, letter in zip(np.eye(3), "xyz", strict=True):
                    yield f"{name}__{letter}", "continuous", axis, joint
            elif kind == _JOINT.mjJNT_SLIDE:
                yield name, "prismatic", model.jnt_axis[joint], joint
            else:
                limited = model.jnt_limited[joint]
                yield name, "revolute" if limited else "continuous", model.jnt_axis[joint], joint

    def _dynamics(self, element: ElementTree.Element, kind: str, joint: int) -> None:
        model = self.model
        effort = min(joint_force(model, joint), NO_LIMIT)
        limit = {"effort": _number(effort), "velocity": _number(NO_LIMIT)}
        if kind == "revolute" or kind == "prismatic":
            low, high = -NO_LIMIT, NO_LIMIT
            if model.jnt_limited[joint]:
                low, high = model.jnt_range[joint] - model.qpos0[model.jnt_qposadr[joint]]
            limit |= {"lower": _number(low), "upper": _number(high)}
        ElementTree.SubElement(element, "limit", limit)
        freedom = int(model.jnt_dofadr[joint])
        damping, friction = model.dof_damping[freedom], model.dof_frictionloss[freedom]
        ElementTree.SubElement(
            element, "dynamics", damping=_number(damping), friction=_number(friction)
        )

    def _link(self, body: int) -> None:
        model = self.model
        link = ElementTree.SubElement(self.root, "link", name=self.links[body])
        if model.body_mass[body] > 0:
            inertial = ElementTree.SubElement(link, "inertial")
            _origin(inertial, model.body_ipos[body] - self.offsets[body], np.eye(3))
            ElementTree.SubElement(inertial, "mass", value=_number(model.body_mass[body]))
            # Along the link's own axes, since some readers ignore a rotation here.
            axes = _matrix(model.body_iquat[body])
            tensor = axes @ np.diag(model.body_inertia[body]) @ axes.T
            pairs = combinations_with_replacement(range(3), 2)
            values = {f"i{'xyz'[i]}{'xyz'[j]}": _number(tensor[i, j]) for i, j in pairs}
            ElementTree.SubElement(inertial, "inertia", values)
        first = int(model.body_geomadr[body])
        for geom in range(first, first + int(model.body_geomnum[body])):
            collides = model.geom_contype[geom] or model.geom_conaffinity[geom]
            for part, (position, shape) in enumerate(self._shapes(geom)):
                name = f"{model.geom(geom).name or f'geom_{geom}'}_{part}"
                for role in ("visual", "collision") if collides else ("visual",):
                    element = ElementTree.SubElement(link, role, name=name)
                    turn = _matrix(model.geom_quat[geom])
                    at = model.geom_pos[geom] + turn @ position - self.offsets[body]
                    _origin(element, at, turn)
                    ElementTree.SubElement(element, "geometry").append(_copy(shape))
                    if role == "visual":
                        self._colour(element, geom)

    def _shapes(self, geom: int) -> Iterator[tuple[Array, ElementTree.Element]]:
        """Yield the shapes that a geom consists of, and where each lies in the geom's frame."""
        model, middle = self.model, np.zeros(3)
        kind, (a, b, c) = int(model.geom_type[geom]), model.geom_size[geom].tolist()
        if kind in (_GEOM.mjGEOM_CAPSULE, _GEOM.mjGEOM_CYLINDER):
            yield middle, _shape("cylinder", radius=_number(a), length=_number(2 * b))
        if kind == _GEOM.mjGEOM_CAPSULE:
            for end in (-b, b):
                yield np.array([0.0, 0.0, end]), _shape("sphere", radius=_number(a))
        elif kind == _GEOM.mjGEOM_SPHERE:
            yield middle, _shape("sphere", radius=_number(a))
        elif kind == _GEOM.mjGEOM_BOX:
            yield middle, _shape("box", size=_text(np.array([2 * a, 2 * b, 2 * c])))
        elif kind in (_GEOM.mjGEOM_MESH, _GEOM.mjGEOM_ELLIPSOID):
            yield middle, _shape("mesh", filename=f"{MESHES}/{self._mesh(geom)}")

    def _mesh(self, geom: int) -> str:
        """Return the file name of a geom's mesh, which is kept once."""
        model, mesh = self.model, int(self.model.geom_dataid[geom])
        if int(model.geom_type[geom]) == _GEOM.mjGEOM_MESH:
            file = f"mesh_{mesh}.stl"
            first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
            start, triangles = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
            vertices = model.mesh_vert[first : first + count]
            faces = model.mesh_face[start : start + triangles]
        else:
            from robomore.envs.solids import geom_solid

            file = f"geom_{geom}.stl"
            found = geom_solid(model, geom).to_mesh()
            vertices, faces = found.vert_properties[:, :3], found.tri_verts
        if file not in self.meshes:
            self.meshes[file] = stl_bytes(vertices, faces)
        return file

    def _colour(self, element: ElementTree.Element, geom: int) -> None:
        material = int(self.model.geom_matid[geom])
        rgba = self.model.geom_rgba[geom] if material < 0 else self.model.mat_rgba[material]
        name = "skin_" + "".join(f"{round(255 * value):02x}" for value in rgba.tolist())
        colour = ElementTree.SubElement(element, "material", name=name)
        ElementTree.SubElement(colour, "color", rgba=_text(rgba))


def _has(model: mujoco.MjModel, kind: mujoco.mjtJoint) -> bool:
    return bool((model.jnt_type == kind).any())


def _unique(names: list[str]) -> list[str]:
    """Return names fit for any reader, each another one."""
    found: list[str] = []
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_.-]", "_", name)
        number = 2
        while plain in found:
            plain, number = f"{re.sub(r'_[0-9]+$', '', plain)}_{number}", number + 1
        found.append(plain)
    return found


def _matrix(quaternion: Array) -> Array:
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


def _origin(element: ElementTree.Element, position: Array, rotation: Array) -> None:
    ElementTree.SubElement(
        element, "origin", xyz=_text(position), rpy=_text(np.array(roll_pitch_yaw(rotation)))
    )


def roll_pitch_yaw(rotation: Array) -> tuple[float, float, float]:
    """Return the angles of Rz(yaw) Ry(pitch) Rx(roll) = `rotation` (3, 3), in rad."""
    sine = -float(rotation[2, 0])
    across = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(sine, across)
    if across < 1e-9:  # Roll and yaw turn about the same axis: all of it is roll.
        return math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0
    roll = math.atan2(rotation[2, 1], rotation[2, 2])
    return roll, pitch, math.atan2(rotation[1, 0], rotation[0, 0])


def _shape(kind: str, **attributes: str) -> ElementTree.Element:
    return ElementTree.Element(kind, attributes)


def _copy(element: ElementTree.Element) -> ElementTree.Element:
    return ElementTree.Element(element.tag, element.attrib)


def _number(value: float) -> str:
    return repr(float(value))


def _text(values: Array) -> str:
    return " ".join(_number(value) for value in values.tolist())
