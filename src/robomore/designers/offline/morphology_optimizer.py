"""A better body from what was measured: a model-based step inside a region of trust.

Efficiency is fitness over volume, and the volume of any body is known without measuring it. So
only log fitness is modelled, and the exact log volume is subtracted: the step sees that a thinner
leg pays as long as the model does not expect it to cost as much fitness.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robomore.designers.offline.plausibility_prior import Prior
from robomore.designers.offline.space import UnitSpace, distances
from robomore.designers.offline.surrogate import GaussianProcess, expected_improvement
from robomore.errors import ProposalFailed
from robomore.identity import derive_seed
from robomore.tasks.task import Task
from robomore.types import Evaluation, Morphology, Slot, Status

Array = NDArray[np.float64]

CANDIDATES = 400
"""Bodies that a step compares."""

TRUST = 0.22
"""Half-width of the region around the best body, in units of each parameter's range."""

SHRINK = 0.6
"""Of the region, after each step from the same best body that brought nothing."""

LEAST_TRUST = 0.04
"""The region never gets smaller."""

FLOOR = 0.02
"""Fitness below this share of the best counts as this share: its logarithm must stay finite."""

BODY_FAULTS = (Status.INVALID_MORPHOLOGY, Status.UNSTABLE)
"""Failures that speak against the body; the others may be the reward's or the machine's."""


class MorphologyOptimizer:
    """Proposes the next body of a fine branch (paper, Alg. 1) without an LLM."""

    def __init__(self, task: Task, seed: int, objective: str) -> None:
        self._task = task
        self._seed = seed
        self._objective = objective
        self._space = UnitSpace(task)
        self._prior = Prior(task)

    def improve(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Morphology:
        """Return a valid body near `best`'s, unlike all in `history`.

        Raises:
            ProposalFailed: no valid body is left in the region of trust.
        """
        random = np.random.default_rng(derive_seed(self._seed, "refine", slot))
        known = {e.design.morphology.parameters for e in (*history, best)}
        centre = self._space.units([best.design.morphology.parameters])[0]
        others = self._space.units(
            list(dict.fromkeys(e.design.morphology.parameters for e in history if e.ok))
        )
        points = self._steps(centre, others, self._trust(best, history), random)
        bodies = self._space.values(points)
        fresh = np.array([tuple(body) not in known for body in bodies.tolist()])
        bodies = bodies[fresh & self._space.valid(bodies)]
        bodies = self._away_from_failures(bodies, (*history, best))
        if not len(bodies):
            raise ProposalFailed(
                f"{self._task.id}: no valid body found near {best.design.morphology.parameters}"
            )
        chosen = bodies[int(np.argmax(self._promise(bodies, best, history)))]
        parameters = tuple(chosen.tolist())
        return Morphology(parameters, self._describe(parameters, best.design.morphology.parameters))

    def _steps(
        self, centre: Array, others: Array, trust: float, random: np.random.Generator
    ) -> Array:
        """Return CANDIDATES points around `centre`, no coordinate further than `trust` from it.

        Some change few coordinates and some many; some change all radii alike; a third moves along
        differences of measured bodies (differential evolution), which know what goes together.
        """
        size, count = len(centre), CANDIDATES
        changed = random.random((count, size)) < random.uniform(1 / size, 1, (count, 1))
        step = random.normal(0, 0.5, (count, size)) * random.uniform(0.1, 1, (count, 1))
        alike = random.random((count, 1)) < 0.3
        step += np.where(alike & self._prior.thickness, random.normal(0, 0.5, (count, 1)), 0)
        changed |= alike & self._prior.thickness
        step *= trust
        if len(others) > 3:
            third = count // 3
            one, other = (others[random.integers(len(others), size=third)] for _ in range(2))
            step[:third] = (one - other) * random.uniform(0.1, 0.7, (third, 1))
        step = np.clip(step, -trust, trust)
        moved: Array = np.clip(centre + np.where(changed, step, 0), 0, 1)
        return moved

    def _away_from_failures(self, bodies: Array, evaluations: Sequence[Evaluation]) -> Array:
        """Return those of `bodies` whose nearest measured body worked, or all if there are none."""
        failed = [e.design.morphology.parameters for e in evaluations if e.status in BODY_FAULTS]
        worked = [e.design.morphology.parameters for e in evaluations if e.ok]
        if not failed or not worked:
            return bodies
        points = self._space.units(bodies)
        to_failed = distances(points, self._space.units(failed)).min(axis=1, initial=np.inf)
        to_worked = distances(points, self._space.units(worked)).min(axis=1, initial=np.inf)
        sound = to_worked <= to_failed
        return bodies[sound] if sound.any() else bodies

    def _promise(self, bodies: Array, best: Evaluation, history: Sequence[Evaluation]) -> Array:
        """Return the expected improvement of each of `bodies`, in log score, (n,)."""
        measured, values, counts = self._evidence((*history, best))
        process = GaussianProcess(self._space.units(measured), values, counts)
        here = np.array([best.design.morphology.parameters])
        known, _ = process.predict(self._space.units(here))
        mean, deviation = process.predict(self._space.units(bodies))
        return expected_improvement(
            mean + self._offset(bodies), deviation, float(known[0] + self._offset(here)[0])
        )

    def _offset(self, bodies: Array) -> Array:
        """Return what is known of the log score without measuring, (n,)."""
        offset = -self._prior.oddity(bodies)
        if self._objective == "efficiency":
            offset = offset - np.log(self._space.volumes(bodies))
        return offset

    def _evidence(self, evaluations: Sequence[Evaluation]) -> tuple[Array, Array, Array]:
        """Return bodies (n, size), log fitness less what the prior knows (n,), and counts (n,).

        The same body under several rewards is one point: each measurement counts after the mean
        effect of its reward is taken off, so that a body is not praised for its reward.
        """
        fitness = [e.fitness for e in evaluations if e.ok and e.fitness is not None]
        least = FLOOR * max([*fitness, 1e-9])
        rows: dict[tuple[float, ...], dict[str, float]] = defaultdict(dict)
        for e in evaluations:
            if e.ok and e.fitness is not None:
                row = rows[e.design.morphology.parameters]
                row[e.design.reward.source] = float(np.log(max(e.fitness, least)))
        effects = _reward_effects(rows)
        bodies = list(rows)
        means = [np.mean([y - effects[reward] for reward, y in rows[b].items()]) for b in bodies]
        values = [float(mean) for mean in means]
        counts = [len(rows[body]) for body in bodies]
        measured = np.array(bodies, dtype=float)
        # Efficiency's volume is exact, so the model is of fitness; its oddity is a guess that the
        # measurements correct.
        return measured, np.array(values) + self._prior.oddity(measured), np.array(counts, float)

    def _trust(self, best: Evaluation, history: Sequence[Evaluation]) -> float:
        """Return the region's half-width: smaller after each step from `best` in vain."""
        reward = best.design.reward.source
        keys = [e.key for e in history]
        since = history[keys.index(best.key) + 1 :] if best.key in keys else ()
        body = best.design.morphology.parameters
        failed = [
            e
            for e in since
            if e.design.reward.source == reward
            and e.design.morphology.parameters != body
            and self._near(e.design.morphology.parameters, body)
        ]
        return max(TRUST * SHRINK ** len(failed), LEAST_TRUST)

    def _near(self, one: Sequence[float], other: Sequence[float]) -> bool:
        gap = self._space.units([one]) - self._space.units([other])
        return bool(np.abs(gap).max() <= TRUST + 1e-6)

    def _describe(self, new: Sequence[float], old: Sequence[float]) -> str:
        change = (self._space.units([new]) - self._space.units([old]))[0]
        said = []
        for i in np.argsort(-np.abs(change), kind="stable")[:3]:
            if abs(change[i]) > 0.01:
                said.append(f"{self._task.names[i]} {old[i]:.3g} -> {new[i]:.3g}")
        before, after = self._task.volume(old), self._task.volume(new)
        return f"{', '.join(said) or 'a small step'}; volume {100 * (after / before - 1):+.0f} %"


def _reward_effects(rows: dict[tuple[float, ...], dict[str, float]]) -> dict[str, float]:
    """Return by how much each reward's log fitness lies above its bodies' means, shrunk to 0."""
    gaps: dict[str, list[float]] = defaultdict(list)
    for row in rows.values():
        mean = np.mean(list(row.values()))
        for reward, value in row.items():
            gaps[reward].append(float(value - mean))
    return {reward: sum(gap) / (len(gap) + 1) for reward, gap in gaps.items()}
