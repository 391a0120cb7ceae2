"""The parts of a model: how thick they are, and which of them MuJoCo lets collide."""

from __future__ import annotations

import mujoco
import numpy as np

from robomore.envs.robots.base import Array

_ROUND = (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CAPSULE)


def radii(model: mujoco.MjModel) -> Array:
    """Return the radius (geoms,) of each geom in m; of one with sides, half of the thinnest."""
    sizes = model.geom_size
    least = np.where(sizes > 0, sizes, np.inf).min(axis=1)
    found: Array = np.where(np.isin(model.geom_type, _ROUND), sizes[:, 0], least)
    return found


def may_collide(model: mujoco.MjModel, one: int, other: int) -> bool:
    """Return whether two geoms, of bodies that are not joined to each other, collide.

    That is what `<contact>` says of them or of their bodies, else what `contype` and `conaffinity`
    say.
    """
    pairs = zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True)
    if any({one, other} == set(pair) for pair in pairs):
        return True
    low, high = sorted(model.geom_bodyid[[one, other]].tolist())
    if (low << 16) + high in model.exclude_signature:
        return False
    return bool(
        model.geom_contype[one] & model.geom_conaffinity[other]
        or model.geom_contype[other] & model.geom_conaffinity[one]
    )
