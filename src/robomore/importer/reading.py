"""Reads an MJCF or URDF file and keeps what is simulated of the robot in it."""

from __future__ import annotations

import os
import re
import warnings
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import msgspec
import mujoco
import numpy as np

from robomore.errors import InputError
from robomore.importer.first_compile import (
    answer,
    can_be_compiled,
    check_amounts,
    compile_first,
)
from robomore.importer.ranges import within_ranges
from robomore.importer.xml_faults import refuse_braces, xml_fault
from robomore.plain_files import what_stands_at
from robomore.suggestions import path_meant
from robomore.tasks.meshes import MOST_BYTES, check_meshes
from robomore.tasks.sizes import check_sizes

SIMPLE_JOINTS = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
"""Types of joints with one position and one velocity."""

FLOOR = "floor"
"""Name of the ground, which is ours: a plane at height 0."""


_MOST_FILE = 16 * 2**20
"""Bytes of a robot's file without what it includes; the largest known has a tenth of it."""

_LONGEST_NAME = 200
"""Characters of a part's name."""


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot as it was read: one tree of links without a world around it.

    Attributes:
        xml: MJCF text in MuJoCo's own spelling. Every part has a name.
        assets: content of the mesh files that the text names.
        home: angle (rad) or position (m) of joints at rest, by name, where the file says it.
        upright: orientation of a free root at rest as a quaternion w, x, y, z.
        notes: what was changed or left out, in words.
    """

    xml: str
    assets: dict[str, bytes]
    home: dict[str, float]
    upright: tuple[float, ...]
    notes: tuple[str, ...]

    def spec(self) -> mujoco.MjSpec:
        """Return the robot as a new `MjSpec`, to be edited and compiled."""
        return mujoco.MjSpec.from_string(self.xml, assets=self.assets)


def read_robot(path: Path, base: str | None = None) -> Robot:
    """Read a robot.

    Args:
        path: an MJCF file (`.xml`) or a URDF file (`.urdf`).
        base: `free` gives the root a free joint if it has none, `fixed` takes it away; `None` keeps
            what an MJCF file says and makes the root of a URDF file free.

    Raises:
        InputError: the file cannot be read, holds no robot, or one that takes too much to compile.
    """
    if (found := what_stands_at(path)) != "a file":
        said = f"{path} is {found}." if found else f"there is no file {path}.{path_meant(path)}"
        raise InputError(f"{said} Name the robot's MJCF or URDF file")
    try:
        with path.open("rb") as file:
            content = file.read(_MOST_FILE + 1)
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror})") from None
    if len(content) > _MOST_FILE:
        raise InputError(
            f"{path} has more than {_MOST_FILE >> 20} MiB; keep meshes in files of their own"
        )
    payload = msgspec.json.encode((str(path), str(Path.cwd()), base))
    compile_first(str(path), f"{__name__}:_read_apart", payload, content)
    robot = _read(path, base)
    can_be_compiled(robot.xml.encode())  # which `robomore new` writes and reads back
    return robot


def _read_apart(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Read a robot; runs in the process with limits."""
    name, folder, base = msgspec.json.decode(payload, type=tuple[str, str, str | None])
    os.chdir(folder)
    return answer(lambda: _read(Path(name), base))


def _read(path: Path, base: str | None) -> Robot:
    """Read a robot as `read_robot` does, without limits."""
    notes: list[str] = []
    try:
        spec = _urdf(path) if path.suffix == ".urdf" else mujoco.MjSpec.from_file(str(path))
        root = _one_robot(spec, notes)
        _set_base(spec, root, base or ("free" if path.suffix == ".urdf" else None), notes)
        _drop_scenery(spec, notes)
        _drop_visuals(spec, notes)
        assets = _assets(spec, path)
        _name_parts(spec)
        _drop_sensors(spec, notes)
        # Links without a joint become part of what they are fixed to, but never of the world.
        spec.compiler.fusestatic = bool(root.joints)
        home, upright = _home(spec, notes)
        with warnings.catch_warnings():
            # It warns of attachments without a prefix; the text is read back below.
            warnings.simplefilter("ignore")
            spec.compile()
            text = spec.to_xml()
        tree = ET.fromstring(text)
        refuse_braces(path, tree)
        check_sizes(path.name, tree)
        check_amounts(str(path), mujoco.MjSpec.from_string(text, assets=assets).compile())
    except (ValueError, OSError) as error:
        raise InputError(xml_fault(path, error)) from None
    return Robot(text, assets, home, upright, tuple(notes))


def _urdf(path: Path) -> mujoco.MjSpec:
    """Return a URDF robot whose root is not welded to the world, as MuJoCo does by default."""
    text = path.read_text(encoding="utf-8")
    options = (
        '<mujoco><compiler fusestatic="false" discardvisual="true" strippath="false"/></mujoco>'
    )
    text = re.sub(r"<mujoco>.*?</mujoco>", "", text, flags=re.DOTALL)
    text = re.sub(r"(<robot\b[^>]*>)", rf"\1{options}", text, count=1)
    text = re.sub(r'filename="([^"]+)"', lambda found: _located(found[1], path), text)
    spec = mujoco.MjSpec.from_string(text)
    spec.compiler.balanceinertia = True
    return spec


def _located(name: str, urdf: Path) -> str:
    """Return a URDF's `filename="…"` with the path of the file that it means."""
    relative = re.sub(r"^(package|file)://", "", name)
    for folder in (urdf.parent, *urdf.resolve().parents):
        for candidate in (folder / relative, folder / relative.partition("/")[2]):
            if candidate.is_file():
                return f'filename="{candidate.resolve()}"'
    return f'filename="{name}"'


def _one_robot(spec: mujoco.MjSpec, notes: list[str]) -> mujoco.MjsBody:
    """Return the root of the tree with the most joints; other trees are removed."""
    roots = list(spec.worldbody.bodies)
    if not roots:
        raise ValueError("its <worldbody> holds no body")

    def joints(body: mujoco.MjsBody) -> int:
        return len(body.joints) + sum(map(joints, body.bodies))

    root = max(roots, key=joints)
    for other in roots:
        if other is not root:
            notes.append(f"`{other.name}` stands beside the robot and is left out")
            spec.delete(other)
    return root


def _set_base(
    spec: mujoco.MjSpec, root: mujoco.MjsBody, base: str | None, notes: list[str]
) -> None:
    free = [joint for joint in root.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE]
    if base == "free" and not root.joints:
        for key in list(spec.keys):
            notes.append(f"the keyframe `{key.name}` is for a fixed base and is left out")
            spec.delete(key)
        root.add_freejoint(name="root")
        notes.append(f"`{root.name}` had no joint to the world: it has a free joint now")
    elif base == "fixed" and free:
        for key in list(spec.keys):
            spec.delete(key)
        for joint in free:
            spec.delete(joint)
        notes.append(f"`{root.name}` is fixed to the world now")


def _home(spec: mujoco.MjSpec, notes: list[str]) -> tuple[dict[str, float], tuple[float, ...]]:
    """Return the pose of the keyframe `home` or `stand`, or else of the first one, by joint.

    A joint that the keyframe puts outside of its range is at the end of the range, with a note.
    """
    upright = (1.0, 0.0, 0.0, 0.0)
    keys = list(spec.keys)
    if not keys:
        return {}, upright
    named = {key.name: key for key in keys}
    key = next((named[name] for name in ("home", "stand", "standing") if name in named), keys[0])
    qpos = np.array(key.qpos, dtype=float)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = spec.compile()
    home: dict[str, float] = {}
    if len(qpos) == model.nq:
        for joint in range(model.njnt):
            at = int(model.jnt_qposadr[joint])
            if int(model.jnt_type[joint]) in SIMPLE_JOINTS:
                home[model.joint(joint).name] = float(qpos[at])
            elif model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
                upright = tuple(qpos[at + 3 : at + 7].tolist())
    home, moved = within_ranges(model, home, f"the keyframe `{key.name}`")
    notes += moved
    for key in keys:
        spec.delete(key)
    return home, upright


def _drop_scenery(spec: mujoco.MjSpec, notes: list[str]) -> None:
    """Remove what belongs to a picture or a world: lights, cameras, floors, walls, textures."""
    world = list(spec.worldbody.geoms)
    if len(world) > 1 or any(geom.type != mujoco.mjtGeom.mjGEOM_PLANE for geom in world):
        names = ", ".join(f"`{geom.name}`" for geom in world if geom.name != FLOOR)
        notes.append(f"the world's own parts are left out ({names}): the ground is a flat floor")
    for part in [*world, *spec.worldbody.sites, *spec.lights, *spec.cameras]:
        spec.delete(part)
    for material in spec.materials:
        material.textures = ["" for _ in material.textures]
    for part in [*spec.textures, *spec.hfields, *spec.skins]:
        spec.delete(part)


def _drop_visuals(spec: mujoco.MjSpec, notes: list[str]) -> None:
    """Remove geoms that touch nothing, if there are others, and meshes that nobody uses."""
    drawn = [geom for geom in spec.geoms if not (geom.contype or geom.conaffinity)]
    if len(drawn) == len(spec.geoms):
        return
    dropped = [geom for geom in drawn if geom.parent.explicitinertial or not _has_mass(geom)]
    for geom in dropped:
        spec.delete(geom)
    if dropped:
        notes.append(
            f"{len(dropped)} geoms that are only drawn are left out: what is shown is what is "
            "simulated"
        )
    bare = [body.name for body in spec.bodies if not body.geoms and body is not spec.worldbody]
    if bare:
        notes.append(f"these links have no solid and add no volume: {', '.join(bare)}")
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if mesh.name not in used and Path(mesh.file).stem not in used:
            spec.delete(mesh)


def _has_mass(geom: mujoco.MjsGeom) -> bool:
    return bool(geom.mass > 0 if np.isfinite(geom.mass) else geom.density > 0)


def _assets(spec: mujoco.MjSpec, path: Path) -> dict[str, bytes]:
    """Return the content of the mesh files; the spec names them without folders from now on."""
    assets: dict[str, bytes] = {}
    folder = path.parent / (spec.meshdir or "")
    for mesh in spec.meshes:
        if not mesh.file:
            continue
        file = folder / mesh.file
        if not file.is_file():
            raise OSError(f"the mesh file {file} is missing")
        mesh.name = mesh.name or file.stem
        name = re.sub(r"[/\\]", "-", f"{mesh.name}{file.suffix.lower()}")
        if name in assets:
            raise OSError(f"two meshes would be called {name}; rename one")
        with file.open("rb") as opened:
            assets[name] = opened.read(MOST_BYTES + 1)
        mesh.file = name
    check_meshes(path.name, assets)
    spec.meshdir = spec.texturedir = ""
    spec.assets = assets
    return assets


def _name_parts(spec: mujoco.MjSpec) -> None:
    """Give a name to every part that has none, since files and rewards call parts by name."""
    for number, body in enumerate(spec.bodies):
        if not body.name:
            body.name = f"link_{number}"
    taken = {geom.name for geom in spec.geoms} | {joint.name for joint in spec.joints}
    taken |= {site.name for site in spec.sites}
    for body in spec.bodies:
        for parts, ending in ((body.geoms, ""), (body.joints, "_joint"), (body.sites, "_site")):
            unnamed = [part for part in parts if not part.name]
            for number, part in enumerate(unnamed, start=1):
                name = f"{body.name}{ending}" + (f"_{number}" if len(unnamed) > 1 else "")
                while name in taken:
                    name += "_"
                taken.add(name)
                part.name = name
    for number, motor in enumerate(spec.actuators):
        if not motor.name:
            motor.name = motor.target or f"motor_{number}"
    named = (*spec.bodies, *spec.geoms, *spec.joints, *spec.sites, *spec.meshes, *spec.sensors)
    for part in (*named, *spec.actuators, *spec.tendons):
        if len(part.name) > _LONGEST_NAME or not part.name.isprintable():
            raise ValueError(
                f"a part is called {part.name[:80]!r}; give it a name of at most {_LONGEST_NAME} "
                "characters, all of which can be printed"
            )


def _drop_sensors(spec: mujoco.MjSpec, notes: list[str]) -> None:
    """Remove sensors of parts that were removed, and range finders, which measure the world."""
    kinds = mujoco.mjtObj
    known = {
        kinds.mjOBJ_BODY: {body.name for body in spec.bodies},
        kinds.mjOBJ_XBODY: {body.name for body in spec.bodies},
        kinds.mjOBJ_SITE: {site.name for site in spec.sites},
        kinds.mjOBJ_GEOM: {geom.name for geom in spec.geoms},
        kinds.mjOBJ_JOINT: {joint.name for joint in spec.joints},
        kinds.mjOBJ_ACTUATOR: {motor.name for motor in spec.actuators},
        kinds.mjOBJ_TENDON: {tendon.name for tendon in spec.tendons},
    }
    for sensor in list(spec.sensors):
        there = sensor.objname in known.get(sensor.objtype, {sensor.objname})
        refers = not sensor.refname or sensor.refname in known.get(sensor.reftype, ())
        if not (there and refers) or sensor.type == mujoco.mjtSensor.mjSENS_RANGEFINDER:
            notes.append(f"the sensor `{sensor.name}` is left out: it measures the world around")
            spec.delete(sensor)
