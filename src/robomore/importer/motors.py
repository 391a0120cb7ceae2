"""Proposes motors for a robot whose file has none, as strong as its weight asks for."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from robomore.importer.edits import MotorGroup
from robomore.importer.feet import contact_names
from robomore.importer.limbs import kind
from robomore.importer.reading import SIMPLE_JOINTS

_STRENGTH = 2.5
"""A motor is so many times as strong as what holds its limb up, or its part of the robot."""

_YIELD = 0.6
"""Error in rad at which a servo applies its whole torque."""

_DAMPING, _ARMATURE = 0.03, 2e-4
"""Of the stiffness in s, and of the torque in s²."""

_GRAVITY = 9.81


def propose_motors(model: mujoco.MjModel) -> tuple[MotorGroup, ...]:
    """Return motors for all joints, alike joints together: servos, and torques for wheels.

    A limit that the file states for a joint (`actuatorfrcrange`, a URDF's `effort`) is kept.
    """
    if model.nu:
        return ()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    feet = [model.body(name).id for name in contact_names(model).values()]
    carriers = _carriers(model, data, feet)
    found: dict[tuple[str, str, float], list[str]] = {}
    for joint in range(model.njnt):
        if int(model.jnt_type[joint]) in SIMPLE_JOINTS:
            name = model.joint(joint).name
            which = "servo" if model.jnt_limited[joint] else "motor"
            torque = float(f"{_torque(model, data, carriers, joint):.2g}")
            found.setdefault((kind(name), which, torque), []).append(name)
    return tuple(_group(joints, which, torque) for (_, which, torque), joints in found.items())


def _group(joints: Sequence[str], which: str, torque: float) -> MotorGroup:
    armature = float(f"{_ARMATURE * torque:.2g}")
    if which == "motor":
        return MotorGroup(tuple(joints), "motor", torque, armature=armature)
    stiffness = float(f"{torque / _YIELD:.2g}")
    damping = float(f"{_DAMPING * stiffness:.2g}")
    return MotorGroup(tuple(joints), "servo", torque, stiffness, damping, armature)


def _torque(
    model: mujoco.MjModel, data: mujoco.MjData, carriers: Sequence[int], joint: int
) -> float:
    """Return the torque in N·m that a joint needs in a pose, to carry or to stand on carriers."""
    stated = float(model.jnt_actfrcrange[joint, 1])
    if model.jnt_actfrclimited[joint] and stated > 0:
        return stated
    body = int(model.jnt_bodyid[joint])
    below = [b for b in range(model.nbody) if _is_below(model, b, body)]
    ends = [data.geom_xpos[g] for g in range(model.ngeom) if model.geom_bodyid[g] in below]
    ends += [data.xpos[b] for b in below]
    anchor = data.xanchor[joint]
    reach = max(float(np.linalg.norm(end - anchor)) for end in ends)
    carried = _GRAVITY * float(model.body_subtreemass[body]) * reach / 2
    standing = 0.0
    if model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE and set(below) & set(carriers):
        weight = _GRAVITY * float(model.body_subtreemass[0])
        standing = weight * reach / max(2, len(carriers))
    return max(_STRENGTH * max(carried, standing), 0.1)


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
