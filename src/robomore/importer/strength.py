"""How strong the motors of a robot are, and how a parameter makes them stronger."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence

import mujoco

from robomore.envs.motor_force import is_plain, joint_of, motor_force
from robomore.importer.amounts import Amount, texts
from robomore.importer.edits import MotorGroup


def strength_of(model: mujoco.MjModel, motors: Sequence[MotorGroup], joint: str) -> float:
    """Return the largest torque in N·m (or force in N) of a motor on a joint; 0 for no limit.

    Args:
        model: of a robot with motors of its own, perhaps.
        motors: that are added.
        joint: its name.
    """
    number = model.joint(joint).id
    found = sum(group.torque for group in motors if joint in group.joints)
    found += sum(_force(model, m) for m in range(model.nu) if joint_of(model, m) == number)
    if model.jnt_actfrclimited[number]:
        found = min(found, float(abs(model.jnt_actfrcrange[number]).max()))
    return found if math.isfinite(found) else 0.0


def strengthen(section: ET.Element, model: mujoco.MjModel, factors: Mapping[str, Amount]) -> None:
    """Multiply what limits the force of a robot's own motors.

    A motor's gear grows, and the limit of a servo, whose gear would change where it goes.

    Args:
        section: the `<actuator>` of the template.
        model: of the robot as it was read.
        factors: by the name of the joint that a motor drives.
    """
    for element in section:
        motor = model.actuator(element.get("name")).id
        joint = joint_of(model, motor)
        factor = None if joint is None else factors.get(model.joint(joint).name)
        if factor is None:
            continue
        if is_plain(model, motor):
            element.set("gear", texts([factor * float(model.actuator_gear[motor, 0])]))
        elif model.actuator_forcelimited[motor]:
            limits = model.actuator_forcerange[motor]
            element.set("forcerange", texts(factor * float(limit) for limit in limits))


def _force(model: mujoco.MjModel, motor: int) -> float:
    force = motor_force(model, motor)
    if is_plain(model, motor) and not model.actuator_ctrllimited[motor]:
        # It takes controls from -1 to 1.
        gain = float(model.actuator_gear[motor, 0] * model.actuator_gainprm[motor, 0])
        force = min(force, abs(gain))
    return force
