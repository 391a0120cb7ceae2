"""The pose at rest that a keyframe of a robot's file says."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import mujoco
import numpy as np

from robomore.envs.root import find_root
from robomore.importer.ranges import within_ranges

_FREE = mujoco.mjtJoint.mjJNT_FREE

_NUMBERS = {_FREE: 7, mujoco.mjtJoint.mjJNT_BALL: 4}
"""Positions of a joint; those of other types have one."""


@dataclass(slots=True)
class Keyframe:
    """Where the joints of one robot are.

    Attributes:
        name: of the keyframe; empty if there is none.
        joints: hinges and sliding joints with their angle (rad) or position (m). They may have no
            name yet.
        upright: orientation of a free root as a quaternion w, x, y, z; empty if it is not said.
    """

    name: str = ""
    joints: list[tuple[mujoco.MjsJoint, float]] = field(default_factory=list)
    upright: tuple[float, ...] = ()


def take_keyframe(spec: mujoco.MjSpec, root: mujoco.MjsBody) -> Keyframe:
    """Return the keyframe `home` or `stand`, or else the first one; all are removed.

    It has to be read before any joint is removed: its numbers belong to all joints of the file.

    Args:
        spec: of the file as it was read.
        root: of the robot, a body of the world.

    Raises:
        ValueError: it has not as many positions as the joints of the file.
    """
    keys = list(spec.keys)
    if not keys:
        return Keyframe()
    named = {key.name: key for key in keys}
    key = next((named[name] for name in ("home", "stand", "standing") if name in named), keys[0])
    qpos = np.array(key.qpos, dtype=float)
    taken = Keyframe(key.name)
    for one in keys:
        spec.delete(one)
    if not len(qpos):
        return taken
    first = 0
    for body in spec.worldbody.bodies:
        for joint in _joints(body):
            numbers = qpos[first : first + _NUMBERS.get(joint.type, 1)]
            first += _NUMBERS.get(joint.type, 1)
            if body != root or not len(numbers):
                continue
            if joint.type not in _NUMBERS:
                taken.joints.append((joint, float(numbers[0])))
            elif joint.type == _FREE:
                taken.upright = tuple(numbers[3:].tolist())
    if first != len(qpos):
        raise ValueError(
            f"the keyframe {taken.name!r} has {len(qpos)} positions (qpos), and the joints of the "
            f"file have {first}"
        )
    return taken


def home(
    spec: mujoco.MjSpec, key: Keyframe, notes: list[str]
) -> tuple[dict[str, float], tuple[float, ...]]:
    """Compile a robot; return its pose at rest by joint, and the orientation of a free root.

    A joint that the keyframe puts outside of its range is at the end of the range, with a note.
    Without a keyframe no joint is named, and the root lies as it does in the file.
    """
    model = spec.compile()
    root = find_root(model)
    free = root.base == "free"
    upright = np.array(key.upright or (model.qpos0[3:7] if free else (1.0, 0.0, 0.0, 0.0)))
    placed = {model.joint(joint).name for joint in root.joints[:2]}  # by the floor, and at x = 0
    pose = {joint.name: angle for joint, angle in key.joints if joint.name not in placed}
    pose, moved = within_ranges(model, pose, f"the keyframe `{key.name}`")
    notes += moved
    return pose, tuple((upright / np.linalg.norm(upright)).tolist())


def _joints(body: mujoco.MjsBody) -> Iterator[mujoco.MjsJoint]:
    """Yield the joints of a body and of all below it, in the order of their positions."""
    yield from body.joints
    for child in body.bodies:
        yield from _joints(child)
