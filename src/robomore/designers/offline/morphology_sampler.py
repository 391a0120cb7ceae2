"""First proposals: believable bodies, each far from all earlier ones."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robomore.designers.offline.plausibility_prior import Prior
from robomore.designers.offline.space import UnitSpace, distances
from robomore.errors import ProposalFailed
from robomore.identity import derive_seed
from robomore.tasks.geometry import Capsule
from robomore.tasks.task import Task
from robomore.types import Morphology, Slot

Array = NDArray[np.float64]

POOL = 512
"""Bodies to choose from: some hundred times as many as are ever asked for at once."""

FAR = 2.0
"""How much log efficiency a doubling of the distance to the nearest earlier body is worth."""


class MorphologySampler:
    """Chooses bodies from a pool that covers the believable part of a task's box.

    The pool starts as valid bodies spread over the whole box, thin ones included. Differential
    evolution with crowding (a child competes with its own parent alone) then raises every member to
    where the prior finds little that is odd, without drawing the pool together. A proposal is the
    member with the best sum of prior merit and distance to what was proposed before.
    """

    def __init__(self, task: Task, seed: int) -> None:
        self._task = task
        self._seed = seed
        self._space = UnitSpace(task)
        self._prior = Prior(task)

    def propose(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        """Return a believable body far from `earlier`.

        Raises:
            ProposalFailed: no valid body was found in the task's box.
        """
        points, merits = self._pool
        random = np.random.default_rng(derive_seed(self._seed, "body", slot))
        # Each place sees its own half, so that a second attempt is another body.
        seen = random.permutation(len(points))[: max(len(points) // 2, 1)]
        worth = merits[seen]
        if earlier:
            others = self._space.units([body.parameters for body in earlier])
            nearest = distances(points[seen], others).min(axis=1)
            worth = worth + FAR * np.log2(np.maximum(nearest, 1e-6))
        chosen = self._space.values(points[seen[np.argmax(worth)]][None])[0]
        return Morphology(tuple(chosen.tolist()), self._describe(chosen))

    @cached_property
    def _pool(self) -> tuple[Array, Array]:
        """Points (n, size) and the log efficiency expected of each (n,)."""
        random = np.random.default_rng(derive_seed(self._seed, "pool", self._task.id))
        points = self._scattered(random)
        merits = self._prior.expected(self._space.values(points))
        # As many rounds as parameters: the more there are, the rarer are sound bodies by chance.
        for _ in range(self._space.size):
            children = _crossed(points, random)
            bodies = self._space.values(children)
            valid = self._space.valid(bodies)
            reached = np.full(len(points), -np.inf)
            reached[valid] = self._prior.expected(bodies[valid])
            better = reached > merits
            points[better], merits[better] = children[better], reached[better]
        return points, merits

    def _scattered(self, random: np.random.Generator) -> Array:
        """Return up to POOL valid points, spread over the box, thickness correlated over limbs."""
        thickness = self._prior.thickness
        found: list[Array] = []
        for _ in range(40):
            points = random.random((POOL, self._space.size))
            # Independent radii would nearly all give a body of middling volume.
            level = random.uniform(0, 0.7, (POOL, 1))
            spread = random.normal(0, 0.12, points.shape)
            points = np.where(thickness, np.clip(level + spread, 0, 1), points)
            found.append(points[self._space.valid(self._space.values(points))])
            if sum(map(len, found)) >= POOL:
                break
        points = np.concatenate(found)[:POOL]
        if len(points) < 4:
            raise ProposalFailed(
                f"{self._task.id}: of {40 * POOL} bodies drawn from its bounds, "
                f"{len(points)} pass its rules"
            )
        return points

    def _describe(self, body: Array) -> str:
        shapes = self._task.shapes(self._task.named(body.tolist()))
        limbs = [shape for shape in shapes if isinstance(shape, Capsule)]
        slenderness = np.median([limb.length / limb.radius for limb in limbs]) if limbs else 0.0
        build = "slender" if slenderness > 20 else "wiry" if slenderness > 8 else "sturdy"
        longest = max((limb.length for limb in limbs), default=0.0)
        size = "long" if longest > 0.8 else "short" if longest < 0.35 else "medium-sized"
        volume = self._task.volume(body.tolist())
        return (
            f"{build}, {size} limbs (median length over radius {slenderness:.0f}, longest "
            f"{longest:.2f} m), {volume:.3g} m^3 in all"
        )


def _crossed(points: Array, random: np.random.Generator) -> Array:
    """Return one child of each point: a difference of two others added to some coordinates."""
    count, size = points.shape
    one, other = (points[random.permutation(count)] for _ in range(2))
    step = random.uniform(0.2, 0.8, (count, 1))
    crossed = random.random((count, size)) < random.uniform(0.1, 0.9, (count, 1))
    return np.clip(np.where(crossed, points + step * (one - other), points), 0, 1)
