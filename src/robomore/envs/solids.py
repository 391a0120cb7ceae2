"""Parts of a robot as solids whose volume, union and distance can be computed (`manifold3d`).

A ball becomes a polyhedron. Where two such balls have one centre, their faces would coincide, and a
file that rounds corners is no longer closed. So each part's ball can be turned by a small angle of
its own, after which no two faces lie in one plane.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.errors import InvalidMorphology

if TYPE_CHECKING:
    from manifold3d import Manifold

FACETS = 64
"""Edges around each round part."""

_MOST_DEGREES = 5.0
_GOLDEN = 0.6180339887498949
"""Multiples of it are spread evenly over the unit interval, and no two are close."""

_TYPES = mujoco.mjtGeom


def geom_solid(
    model: mujoco.MjModel, geom: int, scale: float = 1.0, turn: int | None = None
) -> Manifold:
    """Return one geom as a solid in its own frame.

    Args:
        model: of the robot.
        geom: its index.
        scale: factor for all lengths, which are in m.
        turn: any whole number; balls are turned by angles that it decides. `None` turns nothing.

    Raises:
        InvalidMorphology: a geom of that kind has no volume.
    """
    from manifold3d import Manifold

    kind = int(model.geom_type[geom])
    a, b, c = (float(value) * scale for value in model.geom_size[geom])
    if kind == _TYPES.mjGEOM_SPHERE:
        return _ball(a, turn)
    if kind == _TYPES.mjGEOM_CAPSULE:
        ball = _ball(a, turn)
        return Manifold.batch_hull([ball.translate([0, 0, z]) for z in (-b, b)])
    if kind == _TYPES.mjGEOM_ELLIPSOID:
        return _ball(1.0, turn).scale([a, b, c])
    if kind == _TYPES.mjGEOM_CYLINDER:
        bar = Manifold.cylinder(2 * b, a, a, FACETS, center=True)
        return bar if turn is None else bar.rotate([0, 0, _angles(turn)[2]])
    if kind == _TYPES.mjGEOM_BOX:
        return Manifold.cube([2 * a, 2 * b, 2 * c], center=True)
    if kind == _TYPES.mjGEOM_MESH:
        return _mesh(model, int(model.geom_dataid[geom]), scale)
    name = model.geom(geom).name or f"number {geom}"
    raise InvalidMorphology(f"the geom {name} is no solid (type {_TYPES(kind).name})")


def placed(
    solid: Manifold, rotation: NDArray[np.float64], position: NDArray[np.float64]
) -> Manifold:
    """Return a solid moved to `position` (3,) with `rotation` (9,) or (3, 3)."""
    return solid.transform(np.c_[np.reshape(rotation, (3, 3)), position])


def _ball(radius: float, turn: int | None) -> Manifold:
    from manifold3d import Manifold

    ball = Manifold.sphere(radius, FACETS)
    return ball if turn is None else ball.rotate(_angles(turn))


def _angles(turn: int) -> list[float]:
    """Return three angles in degrees, all above 0."""
    return [_MOST_DEGREES * ((3 * turn + axis + 1) * _GOLDEN % 1.0) for axis in range(3)]


def _mesh(model: mujoco.MjModel, mesh: int, scale: float) -> Manifold:
    """Return a mesh, or the convex hull of one that is not closed, which is what collides."""
    from manifold3d import Manifold, Mesh

    vertices = slice(model.mesh_vertadr[mesh], model.mesh_vertadr[mesh] + model.mesh_vertnum[mesh])
    faces = slice(model.mesh_faceadr[mesh], model.mesh_faceadr[mesh] + model.mesh_facenum[mesh])
    points = np.ascontiguousarray(model.mesh_vert[vertices] * scale, np.float32)
    given = Mesh(points, np.ascontiguousarray(model.mesh_face[faces], np.uint32))
    given.merge()
    found = Manifold(given)
    if found.status().name == "NoError" and found.volume() > 0:
        return found
    return Manifold.hull_points(points)
