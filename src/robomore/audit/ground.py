"""How deep a robot's parts go into the ground, and which of them it stands on."""

from __future__ import annotations

import mujoco
import numpy as np

from robomore.audit.contacts import may_collide
from robomore.envs import terrain
from robomore.envs.robots.base import Array
from robomore.tasks.task import Task
from robomore.tasks.terrain import CELLS, TILE

_ROUND = (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CAPSULE)


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
        # Half the length of a capsule's axis; other shapes are looked at in their centres.
        capsule = model.geom_type[moving] == mujoco.mjtGeom.mjGEOM_CAPSULE
        self._half = np.where(capsule, model.geom_size[moving, 1], 0.0)
        rounded = np.isin(model.geom_type[moving], _ROUND)
        sizes = model.geom_size[moving]
        least = np.where(sizes > 0, sizes, np.inf).min(axis=1)
        self._radius = np.where(rounded, sizes[:, 0], least)
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
        centre = data.geom_xpos[self._geoms]
        axis = data.geom_xmat[self._geoms].reshape(-1, 3, 3)[:, :, 2] * self._half[:, None]
        depth = np.maximum(self._depth(centre - axis), self._depth(centre + axis))
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

    def _depth(self, points: Array) -> Array:
        """Return how deep spheres around `points` (parts, 3) reach into the ground, in radii."""
        depth: Array = (self._height(points) - points[:, 2] + self._radius) / self._radius
        return depth

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
