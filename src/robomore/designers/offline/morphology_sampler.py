"""Proposes morphologies that are plausible and far from all earlier ones."""

from __future__ import annotations

import threading
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robomore.designers.offline.plausibility_prior import PlausibilityPrior
from robomore.errors import ProposalFailed
from robomore.identity import derive_seed
from robomore.tasks.geometry import Capsule
from robomore.tasks.task import Task
from robomore.tasks.unit_space import UnitSpace, distances
from robomore.types import Morphology, Slot

Array = NDArray[np.float64]

POOL = 512
"""Size of the pool, some hundred times the number of proposals in a usual run."""
ROUNDS = 40
"""Rounds of `POOL` draws before giving up on a full pool."""
EXTRA_ROUNDS = 24
"""Rounds of evolution besides one for each parameter."""
DISTANCE_WEIGHT = 1.5
"""Log efficiency that a doubled distance to the nearest earlier morphology is worth."""


_MOST_POOLS = 8
_making = threading.Lock()

_pools: dict[tuple[int, int], tuple[Task, Array, Array]] = {}
"""The latest pools, by the identity of their task, which is kept with them, and the seed. One takes
seconds to make, and the runs of a study ask for the same ones."""


class MorphologySampler:
    """Chooses morphologies from a pool that covers the plausible part of a task's bounds.

    The pool starts as valid morphologies spread over all of the bounds, thin ones included.
    Differential evolution with crowding (a child competes only with its own parent) then improves
    every member under the prior, without drawing the pool together. A proposal is the member with
    the best sum of prior and distance to the earlier proposals.
    """

    def __init__(self, task: Task, seed: int) -> None:
        self._task = task
        self._seed = seed
        self._space = UnitSpace(task)
        self._prior = PlausibilityPrior(task)

    def sample(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        """Return a plausible morphology far from `earlier`.

        Raises:
            ProposalFailed: no valid morphology was found within the task's bounds.
        """
        points, merits = self._pool
        random = np.random.default_rng(derive_seed(self._seed, "morphology", slot))
        # Each slot sees its own half of the pool, so that a second attempt differs.
        seen = random.permutation(len(points))[: max(len(points) // 2, 1)]
        values = merits[seen]
        if earlier:
            others = self._space.units([morphology.parameters for morphology in earlier])
            nearest = distances(points[seen], others).min(axis=1)
            values = values + DISTANCE_WEIGHT * np.log2(np.maximum(nearest, 1e-6))
        chosen = self._space.values(points[seen[np.argmax(values)]][None])[0]
        return Morphology(tuple(chosen.tolist()), self._describe(chosen))

    @property
    def _pool(self) -> tuple[Array, Array]:
        """Points (n, size) and their expected log efficiency (n,)."""
        key = id(self._task), self._seed
        with _making:  # The runs of a study ask from several threads.
            if key not in _pools:
                if len(_pools) == _MOST_POOLS:
                    del _pools[next(iter(_pools))]
                _pools[key] = self._task, *self._evolved()
            _, points, merits = _pools[key]
        return points, merits

    def _evolved(self) -> tuple[Array, Array]:
        random = np.random.default_rng(derive_seed(self._seed, "pool", self._task.id))
        points = self._scattered(random)
        merits = self._prior.log_efficiency(self._space.values(points))
        # With more parameters, good morphologies are rarer by chance, so there are more rounds.
        for _ in range(self._space.size + EXTRA_ROUNDS):
            children = _crossed(points, random)
            values = self._space.values(children)
            valid = self._space.valid(values)
            reached = np.full(len(points), -np.inf)
            reached[valid] = self._prior.log_efficiency(values[valid])
            better = reached > merits
            points[better], merits[better] = children[better], reached[better]
        points.flags.writeable = merits.flags.writeable = False
        return points, merits

    def _scattered(self, random: np.random.Generator) -> Array:
        """Return up to `POOL` valid points within the bounds, whose radii are correlated."""
        found: list[Array] = []
        for _ in range(ROUNDS):
            points = random.random((POOL, self._space.size))
            # Independent radii would give nearly all morphologies a medium volume.
            level = random.uniform(0, 0.7, (POOL, 1))
            spread = random.normal(0, 0.12, points.shape)
            points = np.where(self._space.radii, np.clip(level + spread, 0, 1), points)
            found.append(points[self._space.valid(self._space.values(points))])
            if sum(map(len, found)) >= POOL:
                break
        points = np.concatenate(found)[:POOL]
        if len(points) < 4:
            raise ProposalFailed(
                f"{self._task.id}: of {ROUNDS * POOL} morphologies drawn within its bounds, "
                f"{len(points)} pass its rules"
            )
        return points

    def _describe(self, values: Array) -> str:
        shapes = self._task.solids(self._task.named(values.tolist()))
        limbs = [shape for shape in shapes if isinstance(shape, Capsule)]
        volume = self._task.volume(values.tolist())
        if not limbs:  # of boxes, cylinders or meshes, of which a shape tells the volume alone
            return f"volume {volume:.3g} m³"
        slenderness = np.median([limb.length / limb.radius for limb in limbs])
        build = "thin" if slenderness > 20 else "medium-thick" if slenderness > 8 else "thick"
        longest = max(limb.length for limb in limbs)
        size = "long" if longest > 0.8 else "short" if longest < 0.35 else "medium-long"
        return (
            f"{build}, {size} limbs (median length/radius {slenderness:.0f}, longest limb "
            f"{longest:.2f} m), volume {volume:.3g} m³"
        )


def _crossed(points: Array, random: np.random.Generator) -> Array:
    """Return one child of each point: some coordinates move by a difference of two other points."""
    count, size = points.shape
    one, other = (points[random.permutation(count)] for _ in range(2))
    step = random.uniform(0.2, 0.8, (count, 1))
    crossed = random.random((count, size)) < random.uniform(0.1, 0.9, (count, 1))
    return np.clip(np.where(crossed, points + step * (one - other), points), 0, 1)
