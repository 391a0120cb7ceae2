"""Proposes a pose in which a robot stands, where its file says none."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.root import SIMPLE_JOINTS, find_root
from robomore.importer.limbs import find_links
from robomore.importer.ranges import unit_of
from robomore.importer.reading import Robot

_TRIES = 121
"""Angles of a joint that are tried."""

_LOW = 0.02
"""Fraction of a robot's height below which its root lies on the floor, as ROS's footprints do."""

_PARALLEL = 0.9
"""Cosine above which two hinges bend a limb in one plane."""


@dataclass(frozen=True, slots=True)
class Rest:
    """Where a joint rests.

    Attributes:
        value: angle (rad) or position (m).
        reason: why it was chosen, in words; empty for what the robot's file says.
    """

    value: float
    reason: str = ""


def home_notes(robot: Robot) -> list[str]:
    """Return a note on each joint whose rest `propose_home` chose; alike ones share one."""
    model = robot.spec().compile()
    alike: dict[str, list[str]] = {}
    for name, rest in propose_home(robot, model).items():
        if rest.reason:
            said = f"at rest {rest.value:g} {unit_of(model, name)}, {rest.reason}"
            alike.setdefault(said, []).append(name)
    return [f"{', '.join(f'`{name}`' for name in alike[said])}: {said}" for said in alike]


def propose_home(robot: Robot, model: mujoco.MjModel) -> dict[str, Rest]:
    """Return where the joints rest that do not rest at 0, or at their `ref`.

    A joint whose range leaves that out, such as a dog's knee, rests in the middle of its range. The
    hinge above it then turns so that the end of the limb comes to lie straight below that hinge.
    """
    if robot.home:
        address = {name: int(model.joint(name).qposadr[0]) for name in robot.home}
        given = robot.home.items()
        return {name: Rest(at) for name, at in given if at != model.qpos0[address[name]]}
    data = mujoco.MjData(model)
    data.qpos[:] = model.qpos0
    home: dict[str, Rest] = {}
    bent = []
    for joint in range(model.njnt):
        low, high = (float(limit) for limit in model.jnt_range[joint])
        limited = int(model.jnt_type[joint]) in SIMPLE_JOINTS and model.jnt_limited[joint]
        usual = float(model.qpos0[model.jnt_qposadr[joint]])
        if limited and not low <= usual <= high:
            reason = f"the middle of its range {low:.4g} to {high:.4g}, which leaves out {usual:g}"
            home[model.joint(joint).name] = Rest(_rounded((low + high) / 2, low, high), reason)
            data.qpos[model.jnt_qposadr[joint]] = (low + high) / 2
            bent.append(joint)
    mujoco.mj_kinematics(model, data)
    for joint in bent:
        above = _hinge_above(model, data, joint)
        if above is not None:
            angle, span = _straighten(model, data, above, joint), ""
            if model.jnt_limited[above]:
                low, high = (float(limit) for limit in model.jnt_range[above])
                angle, span = _rounded(angle, low, high), f" (range {low:.4g} to {high:.4g})"
            else:
                angle = round(angle, 3)
            reason = f"so that the end of the limb lies straight below it{span}"
            home[model.joint(above).name] = Rest(angle, reason)
    return home


def lies_low(model: mujoco.MjModel, pose: NDArray[np.float64]) -> bool:
    """Return whether the root of a robot that moves lies on the floor at rest, or below it.

    Args:
        model: of the robot, with the floor.
        pose: (nq,) its pose at rest.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = pose
    mujoco.mj_kinematics(model, data)
    return find_root(model).moves and bool(data.xpos[1, 2] < _LOW * data.geom_xpos[:, 2].max())


def _rounded(angle: float, low: float, high: float) -> float:
    """Return an angle with few digits that is still in its range."""
    return min(max(round(angle, 3), low), high)


def _hinge_above(model: mujoco.MjModel, data: mujoco.MjData, joint: int) -> int | None:
    """Return the parallel hinge of the link before, `None` if there is none."""
    body = int(model.body_parentid[model.jnt_bodyid[joint]])
    for other in range(model.njnt):
        if model.jnt_bodyid[other] != body or model.jnt_type[other] != mujoco.mjtJoint.mjJNT_HINGE:
            continue
        if abs(float(data.xaxis[joint] @ data.xaxis[other])) > _PARALLEL:
            return other
    return None


def _straighten(model: mujoco.MjModel, data: mujoco.MjData, hinge: int, bent: int) -> float:
    """Turn `hinge` until the end of the limb is below it; returns the angle in rad."""
    low, high = model.jnt_range[hinge] if model.jnt_limited[hinge] else (-np.pi, np.pi)
    angles = np.linspace(max(low, -np.pi), min(high, np.pi), _TRIES)
    body, tip = _end_of_limb(model, int(model.jnt_bodyid[bent]))
    address = int(model.jnt_qposadr[hinge])

    def aside(angle: float) -> float:
        data.qpos[address] = angle
        mujoco.mj_kinematics(model, data)
        end = data.xpos[body] + data.xmat[body].reshape(3, 3) @ tip
        away = end - data.xanchor[hinge]
        return float(np.hypot(away[0], away[1])) + (1.0 if away[2] > 0 else 0.0)

    best = float(min(angles, key=aside))
    aside(best)
    return best


def _end_of_limb(model: mujoco.MjModel, body: int) -> tuple[int, NDArray[np.float64]]:
    links = {link.body: link for link in find_links(model).values()}
    while not links[body].leaf:
        body = next(b for b in links if model.body_parentid[b] == body)
    return body, links[body].end
