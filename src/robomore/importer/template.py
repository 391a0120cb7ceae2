"""Turns a robot and its free parameters into an MJCF template with named placeholders.

A changed link is stretched along its axis: what is attached to it moves, its solids grow, and its
mass and inertia follow. Each number that changes is written as an amount of the parameters, so that
filling the template and compiling it anew gives any morphology, and nothing is edited in place. No
placeholder tells the reference: lengths stand there as multiples of the parameter.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.compile import geom_volume
from robomore.errors import InputError
from robomore.importer.amounts import Amount, texts
from robomore.importer.edits import Edit, MassMode, MotorGroup
from robomore.importer.frames import hoist
from robomore.importer.left_out import FLOOR
from robomore.importer.limbs import ROUND, Link, ends, find_links, geoms_of, rotation
from robomore.importer.loops import free_springs, move_anchors
from robomore.importer.reading import Robot
from robomore.importer.strength import strengthen

_PLACED = ("pos", "quat", "euler", "axisangle", "xyaxes", "zaxis", "fromto")
_SIZED = {"geom": (*_PLACED, "size", "mass"), "site": _PLACED, "joint": ("pos", "axis")}
"""Attributes that are written for each part, and so stand in no class of defaults."""

_ROUNDING = 1e-6
"""Lengths in m below which a coordinate is rounding: MuJoCo writes six digits."""

_HEIGHT = 1.0
"""Height in m at which a robot that moves freely stands in its template."""

Matrix = NDArray[Any]


class TemplateWriter:
    """Writes the template of one robot.

    Attributes:
        root: the MJCF text as a tree, which further parts can be added to.
        mesh_volumes: enclosed volume of each mesh in m³ at scale 1.
    """

    def __init__(
        self,
        robot: Robot,
        edits: Sequence[Edit],
        motors: Sequence[MotorGroup] = (),
        mass: MassMode = "density",
        payload: float = 0.5,
    ) -> None:
        """Prepare the template.

        Args:
            robot: as it was read.
            edits: what each parameter changes.
            motors: that are added.
            mass: how mass follows from size.
            payload: fraction of a link's mass that stays as it is in the mode `shell`.

        Raises:
            InputError: two edits change the same of one part.
        """
        self._spec = robot.spec()
        self._model = self._spec.compile()
        self._links = find_links(self._model)
        self._mass, self._payload = mass, payload
        self._stretch: dict[str, Amount] = {}
        self._thicken: dict[str, Amount] = {}
        self._strength: dict[str, Amount] = {}
        self.mesh_volumes: dict[str, float] = {}
        self.root = ET.fromstring(robot.xml)
        self._mend_classes()
        for edit in edits:
            self._note(edit)
        world = self._part("worldbody")
        hoist(world)
        for body in world.findall("body"):
            self._write_body(body)
        move_anchors(self.root, self._model, lambda n, at: self._moved(self._links.get(n), at))
        free_springs(self.root, self._model)
        self._add_floor(world)
        strengthen(self._part("actuator"), self._model, self._strength)
        self._add_motors(motors)

    def text(self) -> str:
        """Return the template."""
        ET.indent(self.root)
        return ET.tostring(self.root, encoding="unicode") + "\n"

    def add(self, section: str, tag: str, **attributes: str) -> None:
        """Add a part to a section, such as a sensor; refuse one whose name the robot has."""
        there = self.root.iter(tag) if section == "worldbody" else self._part(section)
        if (name := attributes.get("name")) and name in {one.get("name") for one in there}:
            raise InputError(
                f"the robot's file has a part called {name!r} in <{section}>, and "
                f"so would a <{tag}> be that the task adds; rename it there"
            )
        ET.SubElement(self._part(section), tag, attributes)

    def _part(self, tag: str) -> ET.Element:
        found = self.root.find(tag)
        return ET.SubElement(self.root, tag) if found is None else found

    def _mend_classes(self) -> None:
        """Take from the classes of defaults what each part says for itself."""
        for group in self.root.iter("default"):
            for tag, names in _SIZED.items():
                for part in group.findall(tag):
                    for name in names:
                        part.attrib.pop(name, None)

    def _note(self, edit: Edit) -> None:
        changed = {"length": self._stretch, "radius": self._thicken, "strength": self._strength}
        kept = changed[edit.changes]
        for name in edit.parts:
            if name in kept:
                raise InputError(
                    f"two parameters change the {edit.changes} of `{name}`; name it in one of them"
                )
            if edit.changes != "strength" and not getattr(self._links[name], edit.changes):
                raise InputError(f"`{name}` has no {edit.changes} that {edit.name} could change")
            kept[name] = Amount({(edit.name,): 1 / edit.reference})

    def _write_body(self, element: ET.Element) -> None:
        hoist(element)
        children = element.findall("body")
        name = element.get("name", "")
        link, model = self._links[name], self._model
        above = int(model.body_parentid[link.body])
        parent = self._links.get(model.body(above).name)
        # What follows the link above is the point at which this one hangs on it.
        hangs = rotation(model.body_quat[link.body]) @ np.array(link.begin)
        moved = self._moved(parent, model.body_pos[link.body] + hangs)
        at = [to - float(away) for to, away in zip(moved, hangs, strict=True)]
        if int(model.body_dofnum[link.body]) == 6:
            # The height at which a file places a robot tells how long its legs are.
            at = [0.0, 0.0, _HEIGHT]
        _place(element, at, model.body_quat[link.body])
        for child in list(element):
            if child.tag == "joint":
                joint = model.joint(child.get("name"))
                if int(joint.type[0]) != int(mujoco.mjtJoint.mjJNT_FREE):
                    child.set("pos", texts(self._moved(link, joint.pos), _ROUNDING))
                    child.set("axis", texts(joint.axis))
                factor = self._strength.get(joint.name)
                if factor is not None and model.jnt_actfrclimited[joint.id]:
                    limits = model.jnt_actfrcrange[joint.id]
                    child.set("actuatorfrcrange", texts(factor * float(one) for one in limits))
            elif child.tag == "site":
                site = model.site(child.get("name"))
                child.set("size", texts(site.size))
                _place(child, self._moved(link, site.pos), site.quat)
            elif child.tag == "geom":
                self._write_geom(child, link)
            elif child.tag == "inertial":
                element.remove(child)
        follows = self._mass == "density" and model.body_geomnum[link.body]
        if link.mass > 0 and not follows:
            self._write_inertia(element, link)
        for child in children:
            self._write_body(child)

    def _moved(self, link: Link | None, point: Any) -> list[Amount | float]:
        """Return where a point of a link is once the link is stretched."""
        stretch = self._stretch.get(link.name) if link else None
        if link is None or stretch is None:
            return [float(value) for value in point]
        axis = np.array(link.axis)
        along = float(np.dot(point - np.array(link.begin), axis))
        beside = np.asarray(point) - along * axis
        return [float(b) + stretch * (along * float(a)) for b, a in zip(beside, axis, strict=True)]

    def _write_geom(self, element: ET.Element, link: Link) -> None:
        model = self._model
        number = model.geom(element.get("name")).id
        kind, size = int(model.geom_type[number]), model.geom_size[number]
        place, quat = model.geom_pos[number], model.geom_quat[number]
        if kind == int(mujoco.mjtGeom.mjGEOM_MESH):
            place, quat = self._file_frame(number)  # whose axes a mesh is scaled along
        stretch = self._stretch.get(link.name, Amount.of(1.0))
        thicken = self._thicken.get(link.name, Amount.of(1.0))
        cosines = np.abs(rotation(quat).T @ np.array(link.axis))
        along = int(np.argmax(cosines))
        straight = cosines[along] > 0.7
        for name in _SIZED["geom"]:
            element.attrib.pop(name, None)
        element.set("type", mujoco.mjtGeom(kind).name.removeprefix("mjGEOM_").lower())
        if kind in ROUND:
            thick = thicken if cosines[2] > 0.7 else Amount.of(1.0)
            element.set("size", texts([thick * float(size[0])]))
            both = [self._moved(link, end) for end in ends(model, number)]
            element.set("fromto", texts([*both[0], *both[1]], _ROUNDING))
        elif kind == int(mujoco.mjtGeom.mjGEOM_SPHERE):
            element.set("size", texts([thicken * float(size[0])]))
            element.set("pos", texts(self._moved(link, place)))
        else:
            factors = [stretch if straight and k == along else thicken for k in range(3)]
            if kind == int(mujoco.mjtGeom.mjGEOM_MESH):
                self._write_mesh(element, number, factors)
            else:
                element.set(
                    "size", texts([f * float(s) for f, s in zip(factors, size, strict=True)])
                )
            _place(element, self._moved(link, place), quat)
        if self._mass == "density":
            element.set("density", f"{self._density(number, link):.9g}")

    def _file_frame(self, geom: int) -> tuple[Any, Any]:
        """Return where the frame of a mesh's file is in the link, which MuJoCo moves into that of
        its inertia: position and quaternion."""
        model, mesh = self._model, int(self._model.geom_dataid[geom])
        back_pos, back_quat = np.zeros(3), np.zeros(4)
        mujoco.mju_negPose(back_pos, back_quat, model.mesh_pos[mesh], model.mesh_quat[mesh])
        place, quat = np.zeros(3), np.zeros(4)
        mujoco.mju_mulPose(
            place, quat, model.geom_pos[geom], model.geom_quat[geom], back_pos, back_quat
        )
        return place, quat

    def _write_mesh(self, element: ET.Element, geom: int, factors: Sequence[Amount]) -> None:
        """Give a geom its own mesh, scaled along the axes of its file."""
        mesh = int(self._model.geom_dataid[geom])
        name = self._model.mesh(mesh).name
        first = next(m for m in self._part("asset").findall("mesh") if _mesh_name(m) == name)
        own = f"{element.get('name')}_mesh"
        copy = ET.SubElement(self._part("asset"), "mesh", {**first.attrib, "name": own})
        # The class of a mesh may say its scale, which only the compiler knows of.
        scale = [float(value) for value in self._spec.meshes[mesh].scale]
        copy.set("scale", texts([f * s for f, s in zip(factors, scale, strict=True)]))
        element.set("mesh", own)
        self.mesh_volumes[own] = geom_volume(self._model, geom) / abs(float(np.prod(scale)))

    def _density(self, geom: int, link: Link) -> float:
        """Return a geom's density in kg/m³: its own, or what a link's stated mass implies."""
        spec = self._spec.geom(self._model.geom(geom).name)
        if not self._spec.body(link.name).explicitinertial:
            if np.isfinite(spec.mass):
                return float(spec.mass) / geom_volume(self._model, geom)
            return float(spec.density)
        whole = sum(geom_volume(self._model, one) for one in geoms_of(self._model, link.body))
        return link.mass / whole if whole else 0.0

    def _write_inertia(self, element: ET.Element, link: Link) -> None:
        """Write mass, centre and inertia of a link, of which a part may be payload."""
        changed = link.name in self._stretch or link.name in self._thicken
        changed &= self._mass != "density"  # a link without a solid has no size that it follows
        fixed = self._payload if self._mass == "shell" and changed else 0.0
        if fixed:
            carried = ET.SubElement(element, "body", {"name": f"{link.name}_payload"})
            _set_inertia(carried, self._model, link.body, fixed)
        axis = np.array(link.axis)
        stretch = self._stretch.get(link.name, Amount.of(1.0))
        thicken = self._thicken.get(link.name, Amount.of(1.0))
        if not changed:
            _set_inertia(element, self._model, link.body, 1.0)
            return
        model, body = self._model, link.body
        grown = stretch * thicken if self._mass == "shell" else stretch
        mass = grown * (float(model.body_mass[body]) * (1 - fixed))
        turned = rotation(model.body_iquat[body])
        inertia = turned @ np.diag(model.body_inertia[body]) @ turned.T * (1 - fixed)
        # The second moment follows the map itself; the inertia is what is across each axis.
        second = np.trace(inertia) / 2 * np.eye(3) - inertia
        along = np.outer(axis, axis)
        linear = _times(along, stretch) + _times(np.eye(3) - along, thicken)
        moment = linear.dot(second.astype(object)).dot(linear.T) * grown
        trace = moment[0, 0] + moment[1, 1] + moment[2, 2]
        tensor = [trace - moment[k, k] for k in range(3)]
        tensor += [-moment[0, 1], -moment[0, 2], -moment[1, 2]]
        inertial = ET.Element("inertial")
        inertial.set("pos", texts(self._moved(link, model.body_ipos[body])))
        inertial.set("mass", texts([mass]))
        inertial.set("fullinertia", texts(tensor))
        element.insert(0, inertial)

    def _add_floor(self, world: ET.Element) -> None:
        model = self._model
        touches = int(np.bitwise_or.reduce(model.geom_contype, initial=1))
        touched = int(np.bitwise_or.reduce(model.geom_conaffinity, initial=1))
        ET.SubElement(world, "light", {"pos": "0 0 3", "dir": "0 0 -1", "directional": "true"})
        touch: dict[str, str] = {}
        for ground in world.findall("geom"):  # the robot's world holds nothing else
            touch = dict(ground.attrib)
            world.remove(ground)
        floor = touch | {"name": FLOOR, "type": "plane", "size": "40 40 0.1", "pos": "0 0 0"}
        # Each bit that the robot uses, so that all that can touch something touches the floor.
        floor |= {"contype": str(touched), "conaffinity": str(touches), "rgba": "0.8 0.8 0.8 1"}
        world.insert(0, ET.Element("geom", floor))

    def _add_motors(self, motors: Sequence[MotorGroup]) -> None:
        joints = {one.get("name"): one for one in self._part("worldbody").iter("joint")}
        for group in motors:
            for name in group.joints:
                torque = self._strength.get(name, Amount.of(1.0)) * group.torque
                if group.armature:
                    joints[name].set("armature", f"{group.armature:.9g}")
                if group.kind == "motor":
                    ranges = {"gear": texts([torque]), "ctrlrange": "-1 1"}
                    self.add("actuator", "motor", name=name, joint=name, **ranges)
                    continue
                low, high = self._model.joint(name).range
                self.add(
                    "actuator",
                    "position",
                    name=name,
                    joint=name,
                    kp=f"{group.stiffness:.9g}",
                    kv=f"{group.damping:.9g}",
                    ctrlrange=f"{low:.9g} {high:.9g}",
                    forcerange=texts([-torque, torque]),
                )


def _place(element: ET.Element, pos: Sequence[Amount | float], quat: Any) -> None:
    for name in _PLACED:
        element.attrib.pop(name, None)
    element.set("pos", texts(pos, _ROUNDING))
    if not np.allclose(np.abs(quat), (1, 0, 0, 0)):
        element.set("quat", texts(quat))


def _set_inertia(element: ET.Element, model: mujoco.MjModel, body: int, share: float) -> None:
    inertial = ET.Element("inertial")
    inertial.set("pos", texts(model.body_ipos[body]))
    inertial.set("quat", texts(model.body_iquat[body]))
    inertial.set("mass", texts([share * float(model.body_mass[body])]))
    inertial.set("diaginertia", texts(share * model.body_inertia[body]))
    element.insert(0, inertial)


def _times(matrix: Matrix, amount: Amount) -> Matrix:
    return np.array([[amount * float(value) for value in row] for row in matrix], dtype=object)


def _mesh_name(element: ET.Element) -> str:
    return element.get("name") or element.get("file", "").rpartition(".")[0]
