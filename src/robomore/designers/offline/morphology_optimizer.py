"""Improves a morphology with a surrogate model within a trust region.

Efficiency is fitness over volume, and the volume of every morphology is known without training. So
the model predicts log fitness only, and the exact log volume is subtracted. A thinner leg is then
chosen as long as the model does not expect it to cost as much fitness as it saves volume.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robomore.designers.offline.plausibility_prior import PlausibilityPrior
from robomore.designers.offline.reward_effects import by_morphology, reward_effects
from robomore.designers.offline.surrogate import GaussianProcess, expected_improvement
from robomore.errors import ProposalFailed
from robomore.identity import derive_seed
from robomore.tasks.task import Task
from robomore.tasks.unit_space import UnitSpace, distances
from robomore.types import Evaluation, Morphology, Slot, Status

Array = NDArray[np.float64]

CANDIDATES = 400
"""Morphologies that one improvement compares."""
TRUST_RADIUS = 0.22
"""Half-width of the trust region around the best morphology, as a fraction of each range."""
SHRINK_FACTOR = 0.6
"""Factor on the half-width for each failed improvement of the same best morphology."""
MIN_TRUST_RADIUS = 0.04
"""Smallest half-width of the trust region."""
RESCALED = 0.15
"""Fraction of the candidates that are the best morphology in another size."""
MAX_RESCALING = 0.4
"""Logarithm of the largest factor of a size, in a trust region of full width."""
FITNESS_FLOOR = 0.02
"""Lower fitness counts as this fraction of the best one, so that its logarithm is finite."""
MORPHOLOGY_FAILURES = (Status.INVALID_MORPHOLOGY, Status.UNSTABLE)
"""Failures that are due to the morphology. Others may be due to the reward or the machine."""


class MorphologyOptimizer:
    """Proposes the next morphology of an improvement (paper, Alg. 1) without an LLM."""

    def __init__(self, task: Task, seed: int, objective: str) -> None:
        self._task = task
        self._seed = seed
        self._objective = objective
        self._space = UnitSpace(task)
        self._prior = PlausibilityPrior(task)

    def improve(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Morphology:
        """Return a valid morphology near `best`'s that is not in `history`.

        Raises:
            ProposalFailed: the trust region holds no valid new morphology.
        """
        random = np.random.default_rng(derive_seed(self._seed, "improve morphology", slot))
        known = {e.design.morphology.parameters for e in (*history, best)}
        old = best.design.morphology.parameters
        centre = self._space.units([old])[0]
        worked = dict.fromkeys(e.design.morphology.parameters for e in history if e.ok)
        others = self._space.units(list(worked))
        points = self._candidates(centre, others, self._trust_radius(best, history), random)
        values = self._space.values(points)
        new = np.array([tuple(row) not in known for row in values.tolist()])
        values = values[new & self._space.valid(values)]
        values = self._away_from_failures(values, (*history, best))
        if not len(values):
            raise ProposalFailed(f"{self._task.id}: no valid new morphology found near {old}")
        chosen = values[int(np.argmax(self._expected_improvement(values, best, history)))]
        parameters = tuple(chosen.tolist())
        return Morphology(parameters, self._describe(parameters, old))

    def _candidates(
        self, centre: Array, others: Array, radius: float, random: np.random.Generator
    ) -> Array:
        """Return `CANDIDATES` points, each coordinate at most `radius` away from `centre`.

        Some points change few coordinates and some many; some change all radii alike, and some are
        the same robot in another size, with its radii as they are. A third moves along differences
        of evaluated morphologies (differential evolution), which show what belongs together.
        """
        size, count = len(centre), CANDIDATES
        changed = random.random((count, size)) < random.uniform(1 / size, 1, (count, 1))
        step = random.normal(0, 0.5, (count, size)) * random.uniform(0.1, 1, (count, 1))
        alike = random.random((count, 1)) < 0.3
        step += np.where(alike & self._space.radii, random.normal(0, 0.5, (count, 1)), 0)
        changed |= alike & self._space.radii
        step *= radius
        if len(others) > 3:
            third = count // 3
            one, other = (others[random.integers(len(others), size=third)] for _ in range(2))
            step[:third] = (one - other) * random.uniform(0.1, 0.7, (third, 1))
        rescaled = random.random((count, 1)) < RESCALED
        sizes = np.exp(MAX_RESCALING * radius / TRUST_RADIUS * random.uniform(-1, 1, (count, 1)))
        step = np.where(
            rescaled, self._space.units(sizes * self._space.values(centre)) - centre, step
        )
        changed = np.where(rescaled, self._space.lengths, changed)
        step = np.clip(step, -radius, radius)
        moved: Array = np.clip(centre + np.where(changed, step, 0), 0, 1)
        return moved

    def _away_from_failures(self, values: Array, evaluations: Sequence[Evaluation]) -> Array:
        """Return the rows whose nearest evaluated morphology worked, or all if there are none."""
        tried = [(e.design.morphology.parameters, e) for e in evaluations]
        failed = [parameters for parameters, e in tried if e.status in MORPHOLOGY_FAILURES]
        worked = [parameters for parameters, e in tried if e.ok]
        if not failed or not worked:
            return values
        points = self._space.units(values)
        to_failed = distances(points, self._space.units(failed)).min(axis=1, initial=np.inf)
        to_worked = distances(points, self._space.units(worked)).min(axis=1, initial=np.inf)
        safe = to_worked <= to_failed
        return values[safe] if safe.any() else values

    def _expected_improvement(
        self, values: Array, best: Evaluation, history: Sequence[Evaluation]
    ) -> Array:
        """Return the expected improvement (n,) of the log score for each row of `values`."""
        process = GaussianProcess(*self._training_data((*history, best)))
        here = np.array([best.design.morphology.parameters])
        known, _ = process.predict(self._space.units(here))
        mean, deviation = process.predict(self._space.units(values))
        return expected_improvement(
            mean + self._offset(values), deviation, float(known[0] + self._offset(here)[0])
        )

    def _offset(self, values: Array) -> Array:
        """Return the part (n,) of the log score that is known without training."""
        offset = -self._prior.penalty(values)
        if self._objective == "efficiency":
            offset = offset - np.log(self._space.volumes(values))
        return offset

    def _training_data(self, evaluations: Sequence[Evaluation]) -> tuple[Array, Array, Array]:
        """Return points (n, size), log fitness without the prior's penalty (n,) and counts (n,).

        A morphology with several rewards is one point. The mean effect of each reward is subtracted
        first, so that no morphology gets credit for its reward.
        """
        # The volume in efficiency is known, so only the fitness is learned.
        learned = "fitness" if self._objective == "efficiency" else self._objective
        measured = [(e, y) for e in evaluations if (y := e.score(learned)) is not None]
        floor = FITNESS_FLOOR * max([*(y for _, y in measured), 1e-9])
        results = [
            (e.design.morphology.parameters, e.design.reward.source, float(np.log(max(y, floor))))
            for e, y in measured
        ]
        rows, effects = by_morphology(results), reward_effects(results)
        alike = [[y - effects[r] for r, ys in row.items() for y in ys] for row in rows.values()]
        means = [np.mean(values) for values in alike]
        counts = np.array([len(values) for values in alike], float)
        tried = np.array(list(rows), dtype=float)
        # The penalty is a guess, which the measurements correct.
        values = np.array(means, float) + self._prior.penalty(tried)
        return self._space.units(tried), values, counts

    def _trust_radius(self, best: Evaluation, history: Sequence[Evaluation]) -> float:
        """Return the half-width of the trust region, smaller after each failed improvement."""
        reward = best.design.reward.source
        keys = [e.key for e in history]
        since = history[keys.index(best.key) + 1 :] if best.key in keys else ()
        old = best.design.morphology.parameters
        since = [e for e in since if e.design.reward.source == reward]
        others = [new for e in since if (new := e.design.morphology.parameters) != old]
        apart = (np.abs(self._space.units([new]) - self._space.units([old])) for new in others)
        failed = sum(bool(step.max() <= TRUST_RADIUS + 1e-6) for step in apart)
        return max(TRUST_RADIUS * SHRINK_FACTOR**failed, MIN_TRUST_RADIUS)

    def _describe(self, new: Sequence[float], old: Sequence[float]) -> str:
        change = (self._space.units([new]) - self._space.units([old]))[0]
        largest = [
            f"{self._task.names[i]} {old[i]:.3g} -> {new[i]:.3g}"
            for i in np.argsort(-np.abs(change), kind="stable")[:3]
            if abs(change[i]) > 0.01
        ]
        before, after = self._task.volume(old), self._task.volume(new)
        changed = ", ".join(largest) or "small changes"
        return f"{changed}; volume {100 * (after / before - 1):+.0f} %"
