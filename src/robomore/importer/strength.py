"""How strong the motors of a robot are."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco

from robomore.importer.edits import MotorGroup


def strength_of(model: mujoco.MjModel, motors: Sequence[MotorGroup], joint: str) -> float:
    """Return the largest torque in N·m (or force in N) on a joint; 0 where nothing limits it.

    Args:
        model: of a robot with motors of its own, perhaps.
        motors: that are added.
        joint: its name.
    """
    for group in motors:
        if joint in group.joints:
            return group.torque
    number = model.joint(joint).id
    found = 0.0
    for motor in range(model.nu):
        of_joint = model.actuator_trntype[motor] == mujoco.mjtTrn.mjTRN_JOINT
        if not of_joint or model.actuator_trnid[motor, 0] != number:
            continue
        if model.actuator_biastype[motor] == mujoco.mjtBias.mjBIAS_NONE:
            found = max(found, abs(float(model.actuator_gear[motor, 0])))
        elif model.actuator_forcelimited[motor]:
            found = max(found, float(model.actuator_forcerange[motor, 1]))
    return found
