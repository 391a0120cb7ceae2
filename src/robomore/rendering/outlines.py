"""What a robot's solids look like from one side: lines with round ends, and sides of boxes."""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_SIDES = 64
"""Points on each rim of a cylinder, and directions in which an outline is looked for."""

_DARK, _LIGHT = 0.8, 0.35
"""Brightness of a side of a box that is turned away from the light, and what light adds to it."""


@dataclass(frozen=True, slots=True)
class View:
    """Where one looks from: three unit vectors in the world.

    Attributes:
        right: of the picture.
        up: of the picture.
        towards: from the scene to the eye.
    """

    right: Array
    up: Array
    towards: Array

    def flat(self, points: Array) -> Array:
        """Return points (..., 3) of the world as points (..., 2) of the picture, in m."""
        return np.stack((points @ self.right, points @ self.up), axis=-1)


@dataclass(frozen=True, slots=True)
class Face:
    """A flat piece of a picture.

    Attributes:
        corners: (n, 2) to the right and up, in m, one after the other.
        brightness: of its colour, 1 for the colour itself.
    """

    corners: Array
    brightness: float = 1.0


@dataclass(frozen=True, slots=True)
class Solid:
    """A solid in the world: a capsule, or what has the points `corners` as its convex hull.

    Attributes:
        start: (3,) one end of the capsule, or of the one that comes closest, in m.
        end: (3,) the other end; the same for a ball.
        radius: of the capsule, in m.
        body: number of its body.
        geom: its own number in the model.
        corners: (n, 3) in m; none of a capsule or a ball.
        axes: (3, 3) of a box, one in each column; `None` for everything else.
    """

    start: Array
    end: Array
    radius: float
    body: int
    geom: int
    corners: Array = field(default_factory=lambda: np.zeros((0, 3)))
    axes: Array | None = None

    @property
    def lowest(self) -> float:
        """Height of its lowest point, in m."""
        if len(self.corners):
            return float(self.corners[:, 2].min())
        return float(min(self.start[2], self.end[2]) - self.radius)

    def faces(self, view: View) -> tuple[Face, ...]:
        """Return the sides of a box that are seen, or the outline; nothing of a capsule."""
        if not len(self.corners):
            return ()
        if self.axes is None:
            return (Face(_outline(view.flat(self.corners))),)
        light = 0.8 * view.up + 0.5 * view.towards - 0.3 * view.right
        light /= np.linalg.norm(light)
        found = []
        for axis in range(3):
            facing = float(self.axes[:, axis] @ view.towards)
            if abs(facing) < 1e-6:  # edge-on
                continue
            side = facing > 0
            normal = self.axes[:, axis] * (1 if side else -1)
            # In the order of `_CORNERS`, so that its neighbours differ in one sign.
            ring = [n for n in range(8) if (_CORNERS[n, axis] > 0) == side]
            ring = [ring[n] for n in (0, 1, 3, 2)]
            brightness = _DARK + _LIGHT * max(0.0, float(normal @ light))
            found.append(Face(view.flat(self.corners[ring]), brightness))
        return tuple(found)


_CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
_TURN = np.linspace(0, 2 * np.pi, _SIDES, endpoint=False)
_RIM = np.array([(np.cos(a), np.sin(a), z) for z in (-1, 1) for a in _TURN])
_BALL = np.array(
    [
        (np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b))
        for b in np.linspace(-np.pi / 2, np.pi / 2, _SIDES // 2 + 1)
        for a in _TURN
    ]
)


def solids(model: mujoco.MjModel, data: mujoco.MjData) -> list[Solid]:
    """Return the solids of everything that is not part of the world itself."""
    return [
        _solid(model, data, geom)
        for geom in range(model.ngeom)
        if model.body_weldid[model.geom_bodyid[geom]]
    ]


def _solid(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Solid:
    body, kind = int(model.geom_bodyid[geom]), int(model.geom_type[geom])
    centre, axes = data.geom_xpos[geom].copy(), data.geom_xmat[geom].reshape(3, 3).copy()
    size = model.geom_size[geom]
    kinds = mujoco.mjtGeom
    if kind in (kinds.mjGEOM_SPHERE, kinds.mjGEOM_CAPSULE):
        reach = axes[:, 2] * size[1] if kind == kinds.mjGEOM_CAPSULE else np.zeros(3)
        return Solid(centre - reach, centre + reach, float(size[0]), body, geom)
    points = _points(model, geom)
    corners = centre + points @ axes.T
    middle, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    centre = centre + axes @ middle
    longest = int(np.argmax(half))
    radius = float(np.delete(half, longest).mean())
    reach = axes[:, longest] * max(0.0, float(half[longest]) - radius)
    box = axes if kind == kinds.mjGEOM_BOX else None
    return Solid(centre - reach, centre + reach, radius, body, geom, corners, box)


def _points(model: mujoco.MjModel, geom: int) -> Array:
    """Return points (n, 3) in m, in the frame of a geom, whose convex hull it is."""
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first = model.mesh_vertadr[mesh]
        return np.array(model.mesh_vert[first : first + model.mesh_vertnum[mesh]], dtype=float)
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return np.asarray(_RIM * (size[0], size[0], size[1]))
    if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
        return np.asarray(_BALL * size)
    middle, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    return np.asarray(middle + _CORNERS * half)


def _outline(points: Array) -> Array:
    """Return the corners (n, 2) of the convex outline of points (m, 2), in their order around."""
    away = np.stack((np.cos(_TURN), np.sin(_TURN)))
    found = np.argmax(points @ away, axis=0)
    return np.asarray(points[list(dict.fromkeys(found.tolist()))])
