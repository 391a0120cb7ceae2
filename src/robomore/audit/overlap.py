"""Parts of a robot that pass through each other because the task switches their collision off."""

from __future__ import annotations

from itertools import combinations

import mujoco
import numpy as np

from robomore.audit.parts import may_collide, radii

LEAST_DEPTH = 0.5
"""Overlap in radii of the thinner part from which on it counts. Neighbours of neighbours touch in
every bent knee, and a little of that is the roundness of capsules."""
_EVERY = 4
"""Poses from one look to the next: an overlap lasts longer, and each look tries all pairs."""


class Overlap:
    """Looks at one pose after the other, and sums up.

    Attributes:
        is_off: whether there are parts, not joined to each other, whose collision is switched off.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        """Find the pairs of parts that should not overlap."""
        self._model = model
        self._radii = radii(model)
        rest = mujoco.MjData(model)
        mujoco.mj_forward(model, rest)
        self._pairs = [
            pair
            for pair in combinations(np.flatnonzero(model.geom_bodyid > 0).tolist(), 2)
            if self._is_off(rest, *pair)
        ]
        self.is_off = bool(self._pairs)
        self._counts = dict.fromkeys(self._pairs, 0)
        self._poses = self._looks = self._overlaps = 0

    @property
    def share(self) -> float:
        """Fraction of the poses in which some pair overlaps."""
        return self._overlaps / self._looks if self._looks else 0.0

    @property
    def worst(self) -> tuple[str, ...]:
        """Names of the pair that overlaps most often; empty if none does."""
        if not self._overlaps:
            return ()
        pair = max(self._counts, key=lambda one: self._counts[one])
        return tuple(self._model.geom(geom).name or f"geom {geom}" for geom in pair)

    def look(self, data: mujoco.MjData) -> None:
        """Take in the pose of `data`."""
        self._poses += 1
        if not self._pairs or self._poses % _EVERY:
            return
        self._looks += 1
        found = [pair for pair in self._pairs if self._depth(data, *pair) > LEAST_DEPTH]
        self._overlaps += bool(found)
        for pair in found:
            self._counts[pair] += 1

    def _is_off(self, rest: mujoco.MjData, one: int, other: int) -> bool:
        model = self._model
        welded = model.body_weldid[model.geom_bodyid[[one, other]]]
        parents = model.body_weldid[model.body_parentid[welded]]
        if welded[0] == welded[1] or welded[0] == parents[1] or welded[1] == parents[0]:
            return False  # joined to each other
        if parents[0] == parents[1] and (model.body_jntnum[welded] > 0).all():
            anchors = rest.xanchor[model.body_jntadr[welded]]
            if np.allclose(*anchors):
                return False  # both hang on the same point, as the thighs of a planar walker
        return not may_collide(model, one, other)

    def _depth(self, data: mujoco.MjData, one: int, other: int) -> float:
        distance: float = mujoco.mj_geomDistance(self._model, data, one, other, 0.0, None)
        return max(0.0, -distance) / float(self._radii[[one, other]].min())
