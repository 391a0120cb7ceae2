"""The largest force that a robot's motors can give, as its MuJoCo model states it."""

from __future__ import annotations

import math

import mujoco
import numpy as np

_ON_JOINT = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)

_WITHOUT_AXIS = (mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL)


def motor_force(model: mujoco.MjModel, motor: int) -> float:
    """Return the largest force (N) or torque (N m) of one actuator behind its gear.

    The control range of a servo is an angle, so a servo has the limit of its `forcerange`, or that
    of its joint. The control range of a plain motor is a force. Infinity if nothing limits it.
    """
    gear = _gear(model, motor)
    found = math.inf
    if model.actuator_forcelimited[motor]:
        found = gear * float(np.abs(model.actuator_forcerange[motor]).max())
    if is_plain(model, motor) and model.actuator_ctrllimited[motor]:
        signal = float(np.abs(model.actuator_ctrlrange[motor]).max())
        found = min(found, gear * signal * abs(float(model.actuator_gainprm[motor, 0])))
    joint = joint_of(model, motor)
    if joint is not None and model.jnt_actfrclimited[joint]:
        found = min(found, float(np.abs(model.jnt_actfrcrange[joint]).max()))
    return found


def _gear(model: mujoco.MjModel, motor: int) -> float:
    """Return the size of a gear, which has a direction on a site and on a joint without an axis."""
    joint = joint_of(model, motor)
    directed = int(model.actuator_trntype[motor]) == mujoco.mjtTrn.mjTRN_SITE
    if joint is not None:
        directed = int(model.jnt_type[joint]) in _WITHOUT_AXIS
    gear = model.actuator_gear[motor]
    return float(np.linalg.norm(gear if directed else gear[:1]))


def is_plain(model: mujoco.MjModel, motor: int) -> bool:
    """Return whether an actuator is a plain motor, whose force is its control times a number."""
    plain = int(model.actuator_biastype[motor]) == mujoco.mjtBias.mjBIAS_NONE
    plain &= int(model.actuator_gaintype[motor]) == mujoco.mjtGain.mjGAIN_FIXED
    plain &= int(model.actuator_dyntype[motor]) != mujoco.mjtDyn.mjDYN_INTEGRATOR
    return bool(plain)


def joint_force(model: mujoco.MjModel, joint: int) -> float:
    """Return the largest force (N) or torque (N m) that all motors of a joint give it together.

    It is 0 without a motor, and infinity if nothing limits it.
    """
    motors = [motor for motor in range(model.nu) if joint_of(model, motor) == joint]
    found = sum((motor_force(model, motor) for motor in motors), 0.0)
    if model.jnt_actfrclimited[joint]:
        found = min(found, float(np.abs(model.jnt_actfrcrange[joint]).max()))
    return found


def joint_of(model: mujoco.MjModel, motor: int) -> int | None:
    """Return the number of the joint that an actuator drives; `None` if it drives no joint."""
    if int(model.actuator_trntype[motor]) not in _ON_JOINT:
        return None
    return int(model.actuator_trnid[motor, 0])
