"""How deep a robot's parts go into the ground, and which of them it stands on."""

from __future__ import annotations

from itertools import product

import mujoco
import numpy as np

from robomore.audit.parts import may_collide, radii
from robomore.envs import terrain
from robomore.envs.robots.base import Array
from robomore.tasks.task import Task
from robomore.tasks.terrain import CELLS, TILE

_Geom = mujoco.mjtGeom


class Ground:
    """Looks at one pose after the other, and sums up.

    The depth is geometry and not a contact: a part that MuJoCo lets through has none.

    Attributes:
        exists: whether any part of the robot can collide with the ground.
    """

    def __init__(self, task: Task, model: mujoco.MjModel) -> None:
        """Prepare to look at poses of `model` on the task's ground."""
        self._model = model
        still = model.geom_bodyid == 0
        self._still = still
        grounds = np.flatnonzero(still).tolist()
        moving = np.flatnonzero(~still).tolist()
        self.exists = any(may_collide(model, one, g) for one in moving for g in grounds)
        self._geoms = moving
        shapes = [_shape(model, geom) for geom in moving]
        self._points = np.concatenate([points for points, _ in shapes])
        counts = [len(points) for points, _ in shapes]
        self._owner = np.repeat(np.arange(len(moving)), counts)
        self._first = np.cumsum([0, *counts[:-1]])
        self._rounding = np.array([rounding for _, rounding in shapes])
        self._radius = radii(model)[moving]
        planes = [g for g in grounds if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_PLANE]
        self._plane = float(model.geom_pos[planes[0], 2]) if planes else 0.0
        bumpy = task.terrain is not None and task.terrain.height
        self._tile = terrain.tile(task.terrain) * task.terrain.height if bumpy else None  # type: ignore[union-attr]
        self._deepest = np.full(len(moving), -np.inf)
        self._deep = self._looks = 0
        self._sunk: list[float] = []
        self._carried = np.zeros(model.ngeom)
        self._force = np.zeros(6)

    @property
    def deep_share(self) -> float:
        """Fraction of the poses in which some part is deeper than its own radius."""
        return self._deep / self._looks if self._looks else 0.0

    @property
    def usual_depth(self) -> float:
        """Depth in m of the deepest part, the median of the poses in which one is in the ground."""
        return float(np.median(self._sunk)) if self._sunk else 0.0

    def depths(self) -> dict[str, float]:
        """Return how deep each part goes at most, in its radii; 0 for one that stays above."""
        return {
            self._model.geom(geom).name or f"geom {geom}": max(0.0, float(depth))
            for geom, depth in zip(self._geoms, self._deepest, strict=True)
        }

    def support(self) -> dict[str, float]:
        """Return the fraction of the ground's force that each part carries."""
        whole = self._carried.sum()
        return {
            self._model.geom(geom).name or f"geom {geom}": float(self._carried[geom] / whole)
            for geom in self._geoms
            if whole > 0 and self._carried[geom] > 0
        }

    def look(self, data: mujoco.MjData) -> None:
        """Take in the pose and the contacts of `data`."""
        if not self.exists:
            return
        turned = data.geom_xmat[self._geoms].reshape(-1, 3, 3)
        points = np.einsum("pij,pj->pi", turned[self._owner], self._points)
        points += data.geom_xpos[self._geoms][self._owner]
        sunk_points = self._height(points) - points[:, 2]
        # How far a rounded part reaches below its points, as it stands.
        below = np.linalg.norm(turned[:, 2] * self._rounding, axis=1)
        depth = (np.maximum.reduceat(sunk_points, self._first) + below) / self._radius
        self._deepest = np.maximum(self._deepest, depth)
        self._deep += bool((depth > 1).any())
        if (sunk := float((depth * self._radius).max())) > 0:
            self._sunk.append(sunk)
        self._looks += 1
        contact = data.contact
        for number, (one, other) in enumerate(contact.geom):
            if self._still[one] == self._still[other]:
                continue
            mujoco.mj_contactForce(self._model, data, number, self._force)
            self._carried[other if self._still[one] else one] += self._force[0]

    def _height(self, points: Array) -> Array:
        if self._tile is None:
            return np.full(len(points), self._plane)
        # The tile repeats, with one in the middle of the world. Rows lie along y.
        cells = ((points[:, :2] / TILE + 0.5) % 1.0) * CELLS
        low = np.minimum(cells.astype(int), CELLS - 1)
        x, y = (cells - low).T
        column, row = low.T
        height: Array = (
            self._tile[row, column] * (1 - x) * (1 - y)
            + self._tile[row, column + 1] * x * (1 - y)
            + self._tile[row + 1, column] * (1 - x) * y
            + self._tile[row + 1, column + 1] * x * y
        )
        return height


def _shape(model: mujoco.MjModel, geom: int) -> tuple[Array, Array]:
    """Return points (n, 3) of a geom in its own frame, and the half axes of the ellipsoid at each.

    The lowest of these ellipsoids ends where the geom does, however it is turned.
    """
    kind, (x, y, z) = model.geom_type[geom], model.geom_size[geom]
    centre, ends = np.zeros((1, 3)), np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    if kind == _Geom.mjGEOM_SPHERE:
        return centre, np.full(3, x)
    if kind == _Geom.mjGEOM_CAPSULE:
        return ends * y, np.full(3, x)
    if kind == _Geom.mjGEOM_CYLINDER:
        return ends * y, np.array([x, x, 0.0])  # a disc
    if kind == _Geom.mjGEOM_ELLIPSOID:
        return centre, np.array([x, y, z])
    if kind == _Geom.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        points = np.array(model.mesh_vert[first : first + count], dtype=np.float64)
        return points[_hull(model, mesh)], np.zeros(3)
    corners = np.array(list(product((-1.0, 1.0), repeat=3)))
    return corners * model.geom_size[geom], np.zeros(3)


def _hull(model: mujoco.MjModel, mesh: int) -> Array | slice:
    """Return which vertices of a mesh lie on its convex hull; all where MuJoCo made none."""
    start = model.mesh_graphadr[mesh]
    if start < 0:
        return slice(None)
    count = model.mesh_graph[start]
    found: Array = model.mesh_graph[start + 2 + count : start + 2 + 2 * count]
    return found
