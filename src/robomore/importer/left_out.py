"""Leaves out of a file what is no part of the robot: scenery, what is only drawn, sensors of it."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

FLOOR = "floor"
"""Name of the ground, which is ours: a plane at height 0."""

_TOUCH = ("friction", "condim", "priority", "solref", "solimp", "solmix", "margin", "gap")
"""What a file's ground keeps: how it touches."""

_QUATERNION = mujoco.mjtOrientation.mjORIENTATION_QUAT


def drop_scenery(spec: mujoco.MjSpec, notes: list[str]) -> None:
    """Remove what belongs to a picture or a world: lights, cameras, walls, textures.

    The ground becomes a level plane called `FLOOR`, which touches as that of the file does.

    Raises:
        ValueError: a part of the robot has that name.
    """
    world = list(spec.worldbody.geoms)
    if any(geom.name == FLOOR for geom in spec.geoms if geom not in world):
        raise ValueError(f"a geom of the robot is called {FLOOR!r}, as the ground is; rename it")
    planes = [geom for geom in world if geom.type == mujoco.mjtGeom.mjGEOM_PLANE]
    ground = next((geom for geom in planes if geom.name == FLOOR), planes[0] if planes else None)
    if len(world) > bool(planes):
        names = ", ".join(f"`{geom.name}`" for geom in world if geom is not ground)
        notes.append(f"the world's own parts are left out ({names}): the ground is a flat floor")
    _add_ground(spec, ground, notes)
    gone = {geom.name for geom in world} - {FLOOR}
    for pair in list(spec.pairs):
        if gone & {pair.geomname1, pair.geomname2}:
            spec.delete(pair)
    needed = _wrapped(spec)
    sites = [site for site in spec.worldbody.sites if site.name not in needed]
    for part in [*world, *sites, *spec.lights, *spec.cameras]:
        spec.delete(part)
    for material in spec.materials:
        material.textures = ["" for _ in material.textures]
    for part in [*spec.textures, *spec.hfields, *spec.skins]:
        spec.delete(part)


def drop_visuals(spec: mujoco.MjSpec, notes: list[str]) -> None:
    """Remove geoms that touch nothing, if there are others, and meshes that nobody uses.

    Raises:
        ValueError: the robot has no solid at all.
    """
    geoms = [geom for body in spec.bodies if body != spec.worldbody for geom in body.geoms]
    if not geoms:
        raise ValueError(
            "the robot has no solid: give its links some that touch things (a URDF's <collision>; "
            "a <visual> is only drawn)"
        )
    touching = _wrapped(spec).union(*({one.geomname1, one.geomname2} for one in spec.pairs))
    drawn = [
        geom
        for geom in geoms
        if not (geom.contype or geom.conaffinity or (geom.name and geom.name in touching))
    ]
    if len(drawn) == len(geoms):
        return
    dropped = [geom for geom in drawn if geom.parent.explicitinertial or not _has_mass(geom)]
    for geom in dropped:
        spec.delete(geom)
    if dropped:
        notes.append(
            f"{len(dropped)} geoms that are only drawn are left out: what is shown is what is "
            "simulated"
        )
    bare = [body.name for body in spec.bodies if not body.geoms and body != spec.worldbody]
    if bare:
        notes.append(f"these links have no solid and add no volume: {', '.join(bare)}")
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if mesh.name not in used and Path(mesh.file).stem not in used:
            spec.delete(mesh)


def drop_sensors(spec: mujoco.MjSpec, notes: list[str]) -> None:
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


def _add_ground(spec: mujoco.MjSpec, ground: mujoco.MjsGeom | None, notes: list[str]) -> None:
    """Add the plane `FLOOR`, which touches as the file's ground does, also in its pairs."""
    plane = {"type": mujoco.mjtGeom.mjGEOM_PLANE, "size": (40, 40, 0.1)}
    if ground is None:
        spec.worldbody.add_geom(name=FLOOR, **plane)
        return
    level = np.allclose(np.abs(ground.quat), (1, 0, 0, 0)) and ground.alt.type == _QUATERNION
    if not level or ground.pos[2]:
        notes.append(f"the ground `{ground.name}` is level here, and at height 0")
    for pair in spec.pairs:
        if ground.name and pair.geomname1 == ground.name:
            pair.geomname1 = FLOOR
        if ground.name and pair.geomname2 == ground.name:
            pair.geomname2 = FLOOR
    touch = {name: getattr(ground, name) for name in _TOUCH}
    ground.name = ""  # two parts of one name cannot be
    spec.worldbody.add_geom(name=FLOOR, **plane, **touch)


def _has_mass(geom: mujoco.MjsGeom) -> bool:
    return bool(geom.mass > 0 if np.isfinite(geom.mass) else geom.density > 0)


def _wrapped(spec: mujoco.MjSpec) -> set[str]:
    """Return the names of the sites and geoms that tendons go through or around."""
    return {wrap.target.name for tendon in spec.tendons for wrap in tendon.path if wrap.target}
