"""How strong the motors of a robot are, and how a free parameter changes that."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence

import mujoco

from robomore.envs.motor_force import joint_of, motor_force
from robomore.importer.amounts import Amount, texts
from robomore.importer.edits import Edit, MotorGroup


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


def strengthen(root: ET.Element, edit: Edit, spec: mujoco.MjSpec, model: mujoco.MjModel) -> None:
    """Write what limits the motors of joints as an amount of a parameter; each keeps its share.

    Args:
        root: of a template with all its motors.
        edit: whose parameter it is.
        spec: of the robot, without motors that are added.
        model: the same compiled.
    """
    factor = Amount({(edit.name,): 1 / edit.reference})
    for motor in root.findall("actuator/*"):
        if motor.get("joint") not in edit.parts:
            continue
        own = spec.actuator(motor.get("name", ""))
        added = own is None
        servo = motor.tag == "position" if added else own.biastype != mujoco.mjtBias.mjBIAS_NONE
        # A servo's gear is its angle's too.
        limit = "forcerange" if servo else "gear"
        if added:
            values = [float(value) for value in motor.get(limit, "").split()]
        elif servo and not model.actuator(own.name).forcelimited[0]:
            continue
        else:
            values = list(own.forcerange if servo else own.gear)
        motor.set(limit, texts(factor * value for value in values))
    for joint in root.findall("worldbody//joint"):
        if joint.get("name") in edit.parts:
            number = model.joint(joint.get("name")).id
            if model.jnt_actfrclimited[number]:
                limits = model.jnt_actfrcrange[number]
                joint.set("actuatorfrcrange", texts(factor * float(one) for one in limits))
