"""How strong the motors of a robot are."""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco

from robomore.envs.motor_force import joint_of, motor_force
from robomore.importer.edits import MotorGroup


def strength_of(model: mujoco.MjModel, motors: Sequence[MotorGroup], joint: str) -> float:
    """Return the largest torque in N·m (or force in N) of a motor on a joint; 0 for no limit.

    Args:
        model: of a robot with motors of its own, perhaps.
        motors: that are added.
        joint: its name.
    """
    for group in motors:
        if joint in group.joints:
            return group.torque
    number = model.joint(joint).id
    own = [motor_force(model, n) for n in range(model.nu) if joint_of(model, n) == number]
    return max((force for force in own if math.isfinite(force)), default=0.0)
