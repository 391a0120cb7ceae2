"""A better reward from what was measured: what its terms did, how the robot moved, what worked."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robomore.designers.offline.reward_composition import RewardComposition, middle
from robomore.designers.offline.reward_sampler import RewardSampler
from robomore.designers.offline.reward_term import Term
from robomore.errors import ProposalFailed
from robomore.identity import derive_seed
from robomore.tasks.task import Task
from robomore.types import Evaluation, Reward, Slot, TermStatistics

OUTWEIGHS, IDLE = 0.6, 0.01
"""A term's mean over the leading term's: above, it drowns the task; below, it is idle."""

SLOW = 0.3
"""Forward speed in m/s below which a robot is said to stand still."""

FELL = 0.5
"""Share of episodes that end in a fall from which on staying upright comes first."""

JERKY = 1.0
"""Mean change of an action component per step, of at most 2, above which a policy rattles."""

ATTEMPTS = 40
"""Changes that are drawn before giving up on finding one that was not tried."""


@dataclass(frozen=True, slots=True)
class Change:
    """One way to change a recipe.

    Attributes:
        recipe: what comes out.
        reason: in words, for people who read the run.
        urgency: how likely it is drawn, relative to the others.
    """

    recipe: RewardComposition
    reason: str
    urgency: float


class RewardOptimizer:
    """Improves rewards for one task (paper, Alg. 1) without an LLM.

    It looks for faults that the measurements show and has a cure for each; it takes terms over from
    rewards that did well; and it tries something at random now and then. One change at a time, so
    that the next round knows what helped.
    """

    def __init__(self, task: Task, seed: int, objective: str) -> None:
        self._task = task
        self._seed = seed
        self._objective = objective
        self._composer = RewardSampler(task, seed)

    def improve(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        """Return a change of `best`'s reward, unlike all in `history`.

        Raises:
            ProposalFailed: the robot has no known term for its task, or all changes were tried.
        """
        random = np.random.default_rng(derive_seed(self._seed, "reweigh", slot))
        tried = {e.design.reward.source for e in (*history, best)}
        recipe = self._composer.recipe(best.design.reward.source)
        if recipe.lead is None:
            raise ProposalFailed(f"{self._task.id}: no reward term for this robot's task is known")
        changes = [
            *self._cures(recipe, best),
            *self._crossings(recipe, best, history),
            *self._trials(recipe, random),
        ]
        urgency = np.array([change.urgency for change in changes])
        for attempt in range(ATTEMPTS):
            change = changes[random.choice(len(changes), p=urgency / urgency.sum())]
            # The same cure in another dose, once the plain one was tried.
            changed = self._jittered(change.recipe, random) if attempt else change.recipe
            source = changed.source(self._composer.body)
            if source not in tried:
                return Reward(source, f"{change.reason}: {changed.idea()}")
        raise ProposalFailed(f"{self._task.id}: every change of this reward was tried already")

    def _cures(self, recipe: RewardComposition, best: Evaluation) -> Iterator[Change]:
        yield from self._cures_of_balance(recipe, best)
        moved = best.behaviour
        falls = moved.get("fell_share", 0.0) >= FELL
        if falls:
            for name in ("alive", "upright", "lean", "riding_height"):
                if (term := self._known(name)) is not None:
                    weight = 1.6 * recipe.weights.get(name, middle(term))
                    yield Change(recipe.having(term, weight), "it falls: steadier", 1.5)
        speed = moved.get("forward_speed_m_s", math.inf)
        if not self._composer.body.jumps and speed < SLOW and not falls:
            for name in ("early_progress", "activity"):
                if (term := self._known(name)) is not None and name not in recipe.weights:
                    yield Change(
                        recipe.having(term, term.high), "it stands still: get it going", 2.0
                    )
            lead = recipe.lead
            if lead is not None:
                # Early in learning, a reward must be loud to be heard over the policy's entropy.
                louder = recipe.having(lead, 2 * recipe.weights[lead.name])
                yield Change(louder, "it stands still: a louder task", 2.0)
            standing = [term.name for term in recipe.terms if term.part in ("survival", "cost")]
            if standing:
                yield Change(
                    _scaled(recipe, standing, 0.4), "it stands still: less for standing", 2.0
                )
        if moved.get("mean_jerk", 0.0) > JERKY:
            term = self._known("jerkiness")
            if term is not None and "jerkiness" not in recipe.weights:
                yield Change(recipe.having(term, middle(term)), "it rattles: smoother", 1.0)

    def _cures_of_balance(self, recipe: RewardComposition, best: Evaluation) -> Iterator[Change]:
        """Yield cures for terms that drown the task, and for terms that do nothing."""
        sizes = {name: _size(best.terms[name]) for name in recipe.weights if name in best.terms}
        lead = recipe.lead
        if lead is None or not sizes.get(lead.name):
            return
        for name, size in sizes.items():
            share = size / sizes[lead.name]
            if name != lead.name and share > OUTWEIGHS:
                factor = max(0.5 * OUTWEIGHS / share, 0.25)
                yield Change(
                    _scaled(recipe, [name], factor),
                    f"{name} outweighed {lead.name} ({size:.2g} against {sizes[lead.name]:.2g})",
                    3.0,
                )
            elif name != lead.name and share < IDLE:
                yield Change(recipe.without([name]), f"{name} did nothing: left out", 0.7)

    def _crossings(
        self, recipe: RewardComposition, best: Evaluation, history: Sequence[Evaluation]
    ) -> Iterator[Change]:
        """Yield takeovers of terms from rewards that did better than their bodies' average."""
        for source, gain in _reward_gains(history, self._objective).items():
            if gain <= 0 or source == best.design.reward.source:
                continue
            other = self._composer.recipe(source)
            apart = [t for t in other.terms if recipe.weights.get(t.name) != other.weights[t.name]]
            for term in apart:
                yield Change(
                    recipe.having(term, other.weights[term.name]),
                    f"{term.name} taken over from a reward that did well",
                    1.5 * min(gain, 1) / len(apart),
                )

    def _trials(self, recipe: RewardComposition, random: np.random.Generator) -> Iterator[Change]:
        """Yield random changes: another leading term, a new term, one less, other weights."""
        for term in self._composer.suitable:
            if term.name in recipe.weights:
                continue
            drawn = recipe.having(term, self._composer.drawn_weight(term, random))
            if term.part == "task":
                count = max(len(self._composer.leads) - 1, 1)
                yield Change(drawn, f"led by {term.name}", 0.5 / count)
            else:
                yield Change(drawn, f"with {term.name}", 0.8 / len(self._composer.suitable))
        for name in recipe.weights:
            if recipe.lead is not None and name != recipe.lead.name:
                yield Change(recipe.without([name]), f"without {name}", 0.3 / len(recipe.weights))
        yield Change(self._jittered(recipe, random), "other weights", 0.5)

    def _known(self, name: str) -> Term | None:
        return next((term for term in self._composer.suitable if term.name == name), None)

    def _jittered(
        self, recipe: RewardComposition, random: np.random.Generator
    ) -> RewardComposition:
        for term in recipe.terms:
            factor = math.exp(random.normal(0, 0.4))
            recipe = recipe.having(term, recipe.weights[term.name] * factor)
        return recipe


def _scaled(recipe: RewardComposition, names: Sequence[str], factor: float) -> RewardComposition:
    """Return the recipe with some weights scaled; a term that would become tiny is left out."""
    for term in recipe.terms:
        if term.name in names:
            weight = recipe.weights[term.name] * factor
            if weight < term.low / 2:
                recipe = recipe.without([term.name])
            else:
                recipe = recipe.having(term, weight)
    return recipe


def _size(statistics: TermStatistics) -> float:
    return abs(statistics.mean)


def _reward_gains(history: Sequence[Evaluation], objective: str) -> dict[str, float]:
    """Return by how many e-folds each reward's score lies above its bodies' means."""
    rows: dict[tuple[float, ...], dict[str, float]] = defaultdict(dict)
    for e in history:
        score = e.score(objective)
        if score is not None and score > 0:
            rows[e.design.morphology.parameters][e.design.reward.source] = math.log(score)
    gaps: dict[str, list[float]] = defaultdict(list)
    for row in rows.values():
        mean = sum(row.values()) / len(row)
        for source, value in row.items():
            gaps[source].append(value - mean)
    return {source: sum(gap) / (len(gap) + 1) for source, gap in gaps.items()}
