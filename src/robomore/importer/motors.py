"""Proposes motors for a robot whose file has none, as strong as its weight asks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.root import SIMPLE_JOINTS, find_root
from robomore.importer.edits import MotorGroup
from robomore.importer.feet import contact_names
from robomore.importer.limbs import anchor, kind

_STRENGTH = 2.5
"""A motor is so many times as strong as what holds its limb up, or its part of the robot."""

_LEVER = 1 / 4
"""A joint of a leg has at least this fraction of the leg's length as its lever: on its toes or out
of balance, the weight does not stand above the ankle."""

_YIELD = 0.6
"""Error in rad at which a servo applies its whole torque."""

_DAMPING, _ARMATURE = 0.03, 2e-4
"""Of the stiffness in s, and of the torque in s²."""

_GRAVITY = 9.81

_LEAST = 0.1
"""Torque in N·m, or force in N, of the weakest motor."""


@dataclass(frozen=True, slots=True)
class ProposedMotors:
    """Motors for alike joints, and what their strength was chosen from.

    Attributes:
        group: the motors.
        reason: in words, for the task file.
    """

    group: MotorGroup
    reason: str


def propose_motors(model: mujoco.MjModel) -> tuple[ProposedMotors, ...]:
    """Return motors for all joints, alike joints together: servos, and torques for wheels.

    Joints that follow others get none, since theirs would work against those. A limit that the file
    states for a joint (`actuatorfrcrange`, a URDF's `effort`) is kept. Others are so strong that a
    leg carries its share of the robot's weight, and any limb its own.
    """
    if model.nu:
        return ()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    feet = [model.body(name).id for name in contact_names(model).values()]
    carriers = _carriers(model, data, feet)
    idle = {*find_root(model).joints, *followers(model)}
    found: dict[tuple[str, str, float], list[str]] = {}
    reasons: dict[tuple[str, str, float], str] = {}
    for joint in range(model.njnt):
        if int(model.jnt_type[joint]) in SIMPLE_JOINTS and joint not in idle:
            name = model.joint(joint).name
            which = "servo" if model.jnt_limited[joint] else "motor"
            exact, reason = _torque(model, data, carriers, joint)
            alike = (kind(name), which, float(f"{exact:.2g}"))
            found.setdefault(alike, []).append(name)
            reasons.setdefault(alike, reason)
    return tuple(
        ProposedMotors(_group(joints, which, torque), reasons[name, which, torque])
        for (name, which, torque), joints in found.items()
    )


def followers(model: mujoco.MjModel) -> dict[int, int]:
    """Return the joints that an equality (a URDF's `mimic`) makes follow another one: number by
    number."""
    joints = (model.eq_type == mujoco.mjtEq.mjEQ_JOINT) & (model.eq_obj2id >= 0)
    equalities = [int(number) for number in np.flatnonzero(joints & (model.eq_active0 != 0))]
    return {int(model.eq_obj1id[one]): int(model.eq_obj2id[one]) for one in equalities}


def _group(joints: Sequence[str], which: str, torque: float) -> MotorGroup:
    armature = float(f"{_ARMATURE * torque:.2g}")
    if which == "motor":
        return MotorGroup(tuple(joints), "motor", torque, armature=armature)
    stiffness = float(f"{torque / _YIELD:.2g}")
    damping = float(f"{_DAMPING * stiffness:.2g}")
    return MotorGroup(tuple(joints), "servo", torque, stiffness, damping, armature)


def _torque(
    model: mujoco.MjModel, data: mujoco.MjData, carriers: Sequence[int], joint: int
) -> tuple[float, str]:
    """Return the torque in N·m that a joint needs to carry its limb or to stand, and why."""
    stated = float(model.jnt_actfrcrange[joint, 1])
    if model.jnt_actfrclimited[joint] and stated > 0:
        return stated, "as the robot's file says"
    body = int(model.jnt_bodyid[joint])
    below = [b for b in range(model.nbody) if _is_below(model, b, body)]
    geoms = [g for g in range(model.ngeom) if model.geom_bodyid[g] in below]
    anchor = data.xanchor[joint]
    ends = [*data.xpos[below], *(end for geom in geoms for end in _ends(model, data, geom))]
    reach = max(float(np.linalg.norm(end - anchor)) for end in ends)
    held = float(model.body_subtreemass[body])
    carried = _STRENGTH * _GRAVITY * held * reach / 2
    reason = f"{_STRENGTH:g} times what holds up {held:.2g} kg at {reach / 2:.2g} m"
    standing = 0.0
    legs = [carrier for carrier in carriers if carrier in below]
    if find_root(model).moves and legs:
        mass, share = float(model.body_subtreemass[0]), max(2, len(carriers))
        length = max(_leg_length(model, data, leg) for leg in legs)
        lever, what = reach, f"{reach:.2g} m"
        if model.jnt_limited[joint] and lever < _LEVER * length:
            lever = _LEVER * length
            what = f"{lever:.2g} m, a quarter of its leg"
        standing = _STRENGTH * _GRAVITY * mass * lever / share
        if standing > carried:
            reason = f"{_STRENGTH:g} times what holds up 1/{share} of {mass:.3g} kg at {what}"
    return max(carried, standing, _LEAST), reason


def _ends(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> NDArray[np.float64]:
    """Return the ends (2, 3) of a solid along its longest side, in m in the world.

    Those of a capsule are the middles of its round ends.
    """
    middle, half = model.geom_aabb[geom, :3].copy(), model.geom_aabb[geom, 3:]
    away = np.zeros(3)
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CAPSULE:
        away[2] = model.geom_size[geom, 1]
    else:
        away[np.argmax(half)] = half.max()
    axes = data.geom_xmat[geom].reshape(3, 3)
    return np.asarray(data.geom_xpos[geom] + np.stack((middle - away, middle + away)) @ axes.T)


def _leg_length(model: mujoco.MjModel, data: mujoco.MjData, end: int) -> float:
    """Return the length in m of the way along a leg, from its first joint to its end."""
    geoms = np.flatnonzero(model.geom_bodyid == end)

    def hangs(body: int) -> NDArray[np.float64]:
        turned = data.xmat[body].reshape(3, 3)
        return np.asarray(data.xpos[body] + turned @ anchor(model, body))

    length = max(
        float(np.linalg.norm(point - hangs(end)))
        for geom in geoms
        for point in _ends(model, data, int(geom))
    )
    body = end
    while int(model.body_parentid[body]) > 1:
        parent = int(model.body_parentid[body])
        length += float(np.linalg.norm(hangs(body) - hangs(parent)))
        body = parent
    return length


def _carriers(model: mujoco.MjModel, data: mujoco.MjData, feet: Sequence[int]) -> list[int]:
    """Return the ends of limbs that stand on the ground: the lowest ones."""
    if not feet:
        return []
    heights = {foot: float(data.xipos[foot, 2]) for foot in feet}
    lowest, highest = min(heights.values()), float(data.xipos[1:, 2].max())
    return [foot for foot, z in heights.items() if z <= lowest + 0.2 * (highest - lowest) + 1e-6]


def _is_below(model: mujoco.MjModel, body: int, above: int) -> bool:
    while body and body != above:
        body = int(model.body_parentid[body])
    return body == above
