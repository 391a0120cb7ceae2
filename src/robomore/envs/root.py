"""How a robot's root moves in the world: freely, in the plane of x and z, or not at all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SIMPLE_JOINTS = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
"""Types of joints with one position and one velocity."""

_ALONG = 0.99
"""Cosine from which on a joint's axis counts as one of the world's."""


@dataclass(frozen=True, slots=True)
class Root:
    """The first body of a robot.

    Attributes:
        base: `free` with a free joint; `planar` where undriven joints without limits let it slide
            along x and z, and turn in that plane, perhaps; else `fixed`.
        joints: numbers of the joints that move it with its base; none if it is fixed.
        along: place in `qpos` of x.
        up: place in `qpos` of z.
        lean: place in `qpos` of the angle in the plane, `None` if there is none.
        origin: (2,) x and z in m where `qpos` is 0 in these places, or of a fixed root.
    """

    base: Literal["free", "planar", "fixed"]
    joints: tuple[int, ...]
    along: int
    up: int
    lean: int | None
    origin: Array

    @property
    def moves(self) -> bool:
        """Whether it gets anywhere."""
        return self.base != "fixed"

    def position(self, qpos: Array) -> Array:
        """Return x and z (n, 2) in m of the root for positions (n, nq)."""
        if self.base == "fixed":
            return np.broadcast_to(self.origin, (len(qpos), 2)).copy()
        return qpos[:, [self.along, self.up]] + self.origin


def find_root(model: mujoco.MjModel) -> Root:
    """Return how the root of a robot moves."""
    first, count = int(model.body_jntadr[1]), int(model.body_jntnum[1])
    own = range(first, first + count) if count else range(0)
    place = model.body_pos[1, [0, 2]].copy()
    if any(model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE for joint in own):
        start = int(model.jnt_qposadr[first])
        return Root("free", (first,), start, start + 2, None, np.zeros(2))
    along = _undriven(model, own, mujoco.mjtJoint.mjJNT_SLIDE, (1, 0, 0))
    up = _undriven(model, own, mujoco.mjtJoint.mjJNT_SLIDE, (0, 0, 1))
    if along is None or up is None:
        return Root("fixed", (), 0, 0, None, place)
    lean = _undriven(model, own, mujoco.mjtJoint.mjJNT_HINGE, (0, 1, 0))
    joints = tuple(joint for joint in (along, up, lean) if joint is not None)
    at = [int(model.jnt_qposadr[joint]) for joint in joints]
    origin = place - model.qpos0[at[:2]]
    return Root("planar", joints, at[0], at[1], at[2] if lean is not None else None, origin)


def _undriven(
    model: mujoco.MjModel, joints: range, kind: mujoco.mjtJoint, axis: tuple[int, int, int]
) -> int | None:
    """Return the joint about or along an axis of the world that neither ends nor has a motor."""
    turned = np.empty(3)
    driven = model.actuator_trnid[model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT, 0]
    for joint in joints:
        mujoco.mju_rotVecQuat(turned, model.jnt_axis[joint], model.body_quat[1])
        # A hinge may turn the other way round; what slides has to count forward and upward.
        cosine = float(turned @ np.array(axis, dtype=float))
        cosine = abs(cosine) if kind == mujoco.mjtJoint.mjJNT_HINGE else cosine
        if model.jnt_type[joint] == kind and cosine > _ALONG:
            return None if model.jnt_limited[joint] or joint in driven else joint
    return None
