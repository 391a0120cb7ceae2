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

from robomore.errors import InputError
from robomore.importer.first_compile import (
    answer,
    can_be_compiled,
    check_amounts,
    compile_first,
)
from robomore.importer.keyframe import home, take_keyframe
from robomore.importer.left_out import drop_scenery, drop_sensors, drop_visuals
from robomore.importer.urdf import is_urdf, read_urdf
from robomore.importer.xml_faults import refuse_braces, xml_fault
from robomore.plain_files import what_stands_at
from robomore.suggestions import path_meant
from robomore.tasks.meshes import MOST_BYTES, check_meshes
from robomore.tasks.sizes import check_sizes

_MOST_FILE = 16 * 2**20
"""Bytes of a robot's file without what it includes; the largest known has a tenth of it."""

_LARGEST = 25.0
"""Distance in m from the middle of a solid to its end."""

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
        urdf = is_urdf(path.read_bytes())
        spec = read_urdf(path) if urdf else mujoco.MjSpec.from_file(str(path))
        root = _root(spec)
        keyframe = take_keyframe(spec, root)
        _drop_others(spec, root, notes)
        _set_base(spec, root, base or ("free" if urdf else None), notes)
        drop_scenery(spec, notes)
        drop_visuals(spec, notes)
        assets = _assets(spec, path)
        _name_parts(spec)
        drop_sensors(spec, notes)
        # Links without a joint become part of what they are fixed to, but never of the world.
        spec.compiler.fusestatic = bool(root.joints)
        with warnings.catch_warnings():
            # It warns of attachments without a prefix; the text is read back below.
            warnings.simplefilter("ignore")
            rest, upright = home(spec, keyframe, notes)
            text = spec.to_xml()
        tree = ET.fromstring(text)
        refuse_braces(path, tree)
        check_sizes(path.name, tree)
        model = mujoco.MjSpec.from_string(text, assets=assets).compile()
        check_amounts(str(path), model)
        _refuse_millimetres(path, model)
    except (ValueError, OSError) as error:
        raise InputError(xml_fault(path, error)) from None
    return Robot(text, assets, rest, upright, tuple(notes))


def _root(spec: mujoco.MjSpec) -> mujoco.MjsBody:
    """Return the root of the tree with the most joints."""
    roots = list(spec.worldbody.bodies)
    if not roots:
        raise ValueError("its <worldbody> holds no body")

    def joints(body: mujoco.MjsBody) -> int:
        return len(body.joints) + sum(map(joints, body.bodies))

    return max(roots, key=joints)


def _drop_others(spec: mujoco.MjSpec, root: mujoco.MjsBody, notes: list[str]) -> None:
    for other in list(spec.worldbody.bodies):
        if other != root:
            notes.append(f"`{other.name}` stands beside the robot and is left out")
            spec.delete(other)


def _set_base(
    spec: mujoco.MjSpec, root: mujoco.MjsBody, base: str | None, notes: list[str]
) -> None:
    free = [joint for joint in root.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE]
    if base == "free" and not free and root.joints:
        names = ", ".join(f"`{joint.name}`" for joint in root.joints)
        raise ValueError(
            f"its root `{root.name}` hangs from the world by joints ({names}); give it a "
            "<freejoint/> in their place, or leave `--base free` out"
        )
    if base == "free" and not root.joints:
        root.add_freejoint(name="root")
        notes.append(f"`{root.name}` had no joint to the world: it has a free joint now")
    elif base == "fixed" and free:
        for joint in free:
            spec.delete(joint)
        notes.append(f"`{root.name}` is fixed to the world now")


def _refuse_millimetres(path: Path, model: mujoco.MjModel) -> None:
    """Refuse a robot whose lengths cannot be in m.

    Raises:
        InputError: naming the longest part.
    """
    parts = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom]]
    longest = max(parts, key=lambda geom: float(model.geom_rbound[geom]))
    if (reach := float(model.geom_rbound[longest])) > _LARGEST:
        raise InputError(
            f"{path}: the solid `{model.geom(longest).name}` reaches {reach:.3g} m from its "
            f"middle; the most is {_LARGEST:g} m. Lengths are in m: divide those in mm by 1000, "
            'and give a mesh in mm scale="0.001 0.001 0.001"'
        )


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
