"""Is a rest pose within the ranges of a robot's joints, and of its motors' controls?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.control_map import ControlMap

_NEAR = 0.1
"""Fraction of what an action moves in both directions; with less in one of them it is one-sided."""

_MOST_TOLD = 8
"""Findings that a note tells."""

ROUNDING = 1e-5
"""Distance in rad or m beyond a range that is rounding: files hold some six digits."""


def within_ranges(
    model: mujoco.MjModel, pose: Mapping[str, float], what: str
) -> tuple[dict[str, float], list[str]]:
    """Return a pose in which every joint is within its range, and a note if it had to be moved.

    Args:
        model: of the robot.
        pose: angle (rad) or position (m) by joint, of hinges and sliding joints.
        what: words for the pose, for the note.
    """
    kept = dict(pose)
    moved: dict[str, list[str]] = {}
    for name, value in pose.items():
        joint = model.joint(name).id
        if not model.jnt_limited[joint]:
            continue
        low, high = (float(limit) for limit in model.jnt_range[joint])
        kept[name] = min(max(value, low), high)
        if abs(kept[name] - value) > ROUNDING:
            told = (
                f"{value:.4g} became {kept[name]:.4g} {unit_of(model, name)} (range {low:.4g} to "
                f"{high:.4g})"
            )
            moved.setdefault(told, []).append(name)
    if not moved:
        return kept, []
    return kept, [
        f"{what} lies outside the range of joints: {_some(moved)}; choose another in "
        "[home.joints], or widen the range in the robot's file"
    ]


def one_sided(model: mujoco.MjModel, qpos: NDArray[np.float64], reach: float) -> list[str]:
    """Return notes on motors whose actions can hardly move them, or not at all, to one side.

    Args:
        model: of the robot, with its motors.
        qpos: (nq,) its pose at rest.
        reach: fraction of the control ranges that actions use.
    """
    control = ControlMap(model, qpos, reach)
    least, middle, most = (control.controls(np.full(model.nu, at)) for at in (-1.0, 0.0, 1.0))
    moved = list(zip(least, middle, most, strict=True))
    centred: dict[str, list[str]] = {}
    leaning: dict[str, list[str]] = {}
    unlimited = _without_range(model)
    for motor in range(model.nu):
        if motor in unlimited:
            continue
        name, rest = model.actuator(motor).name, round(control.holding[motor], 6) + 0.0  # no -0
        low, zero, high = moved[motor]
        span = f"actions -1, 0, 1 are the controls {low:.3g}, {zero:.3g}, {high:.3g}"
        if control.centred[motor]:
            lacking = "" if low <= rest <= high else ", so none of them holds the rest pose"
            centred.setdefault(f"rests at {rest:.3g}, {span}{lacking}", []).append(name)
        elif min(zero - low, high - zero) < _NEAR * (high - low):
            leaning.setdefault(span, []).append(name)
    remedy = "choose a rest pose further inside in [home.joints]"
    notes = _unranged(model, unlimited, [f"{a:.3g}, {b:.3g}, {c:.3g}" for a, b, c in moved])
    if centred:
        wider = f", or a reach above {reach:g}" if reach < 1 else ""
        notes.append(
            "the rest pose is at an end of a control range or outside, so the action 0 is the "
            f"middle of that range: {_some(centred)}; {remedy}{wider}"
        )
    if leaning:
        notes.append(
            "the rest pose is close to an end of a control range, so actions move nearly to one "
            f"side only: {_some(leaning)}; {remedy}"
        )
    return notes


def _without_range(model: mujoco.MjModel) -> dict[int, list[float]]:
    """Return the ends of what a servo should be given, of each that has no range of controls.

    They are those of its joint; a servo whose joint has none, or moves from -1 to 1, is left out.
    """
    found: dict[int, list[float]] = {}
    for motor in range(model.nu):
        joint = int(model.actuator_trnid[motor, 0])
        held = (
            model.actuator_biastype[motor] == mujoco.mjtBias.mjBIAS_AFFINE
            and model.actuator_biasprm[motor, 1] != 0
            and model.actuator_dyntype[motor] != mujoco.mjtDyn.mjDYN_INTEGRATOR
            and int(model.actuator_trntype[motor])
            in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
        )
        if not held or model.actuator_ctrllimited[motor] or not model.jnt_limited[joint]:
            continue
        gear = float(model.actuator_gear[motor, 0])
        ends = sorted(float(end) * gear for end in model.jnt_range[joint])
        if not np.allclose(ends, (-1.0, 1.0)):
            found[motor] = ends
    return found


def _unranged(
    model: mujoco.MjModel, servos: Mapping[int, Sequence[float]], moved: Sequence[str]
) -> list[str]:
    """Return a note on servos that move from -1 to 1 although their joints have another range.

    Args:
        model: of the robot.
        servos: ends of the range of controls that each should have, by motor.
        moved: controls of the actions -1, 0, 1 of all motors, in words.
    """
    told: dict[str, list[str]] = {}
    for motor, (low, high) in servos.items():
        # MuJoCo takes over a joint's range as it is, whatever the gear.
        same = ' or inheritrange="1"' if model.actuator_gear[motor, 0] == 1 else ""
        said = (
            f"actions -1, 0, 1 are the controls {moved[motor]}; give it "
            f'ctrlrange="{low:.6g} {high:.6g}"{same}'
        )
        told.setdefault(said, []).append(model.actuator(motor).name)
    if not told:
        return []
    return [
        "servos without a ctrlrange take controls from -1 to 1, which is not the range of their "
        f"joints: {_some(told)} in the robot's file"
    ]


def unit_of(model: mujoco.MjModel, joint: str) -> str:
    """Return the unit of a joint's position: `m` of a sliding joint, else `rad`."""
    slides = model.jnt_type[model.joint(joint).id] == mujoco.mjtJoint.mjJNT_SLIDE
    return "m" if slides else "rad"


def _some(told: Mapping[str, Sequence[str]]) -> str:
    """Return the first findings, each with the names of whom it is about."""
    findings = [f"{', '.join(f'`{name}`' for name in told[one])}: {one}" for one in told]
    more = [f"and {len(told) - _MOST_TOLD} more"] if len(told) > _MOST_TOLD else []
    return "; ".join([*findings[:_MOST_TOLD], *more])
