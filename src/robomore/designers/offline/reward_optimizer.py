"""Improves a reward by what was measured: its terms, the robot's motion, and other rewards."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robomore.designers.offline.reward_composition import RewardComposition, middle
from robomore.designers.offline.reward_effects import reward_effects
from robomore.designers.offline.reward_sampler import RewardSampler
from robomore.designers.offline.reward_terms import Term
from robomore.errors import ProposalFailed
from robomore.identity import derive_seed
from robomore.tasks.task import Task
from robomore.types import Evaluation, Reward, Slot

DOMINANT, NEGLIGIBLE = 0.6, 0.01
"""Mean of a term over that of the leading term, above which it dominates the task, and below which
it has no effect."""
SLOW = 0.3
"""Forward speed in m/s below which a robot counts as standing still."""
FALL_FRACTION = 0.5
"""Fraction of episodes with a fall from which on stability comes first."""
JERKY = 1.0
"""Mean change of an action per step (at most 2) above which the actions count as jerky."""
DRAWS = 40
"""Changes that are drawn before giving up on an untried one."""


@dataclass(frozen=True, slots=True)
class Change:
    """A changed reward, the reason in words for people, and the relative probability of a draw."""

    composition: RewardComposition
    reason: str
    weight: float


class RewardOptimizer:
    """Improves rewards for one task (paper, Alg. 1) without an LLM.

    It corrects faults that the evaluations show, copies terms from rewards with good scores, and
    sometimes changes something at random. It makes one change at a time, so that the next
    evaluation shows what helped.
    """

    def __init__(self, task: Task, seed: int, objective: str) -> None:
        self._task = task
        self._seed = seed
        self._objective = objective
        self._sampler = RewardSampler(task, seed)

    def improve(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        """Return a change of `best`'s reward that is not in `history`.

        Raises:
            ProposalFailed: no term for the task itself suits the robot, or all changes were tried.
        """
        random = np.random.default_rng(derive_seed(self._seed, "improve reward", slot))
        tried = {e.design.reward.source for e in (*history, best)}
        composition = self._sampler.composition(best.design.reward.source)
        if composition.lead is None:
            raise ProposalFailed(f"{self._task.id}: no reward term for this robot's task is known")
        changes = [
            *self._corrections(composition, best),
            *self._copies(composition, best, history),
            *self._random_changes(composition, random),
        ]
        weights = np.array([change.weight for change in changes])
        for draw in range(DRAWS):
            change = changes[random.choice(len(changes), p=weights / weights.sum())]
            # If the plain change was tried already, its weights are varied.
            changed = self._jittered(change.composition, random) if draw else change.composition
            source = changed.source(self._sampler.robot)
            if source not in tried:
                return Reward(source, f"{change.reason}: {changed.idea()}")
        raise ProposalFailed(f"{self._task.id}: every change of this reward was tried already")

    def _corrections(self, composition: RewardComposition, best: Evaluation) -> Iterator[Change]:
        yield from self._corrections_of_balance(composition, best)
        moved = best.behaviour
        falls = moved.get("fell_share", 0.0) >= FALL_FRACTION
        if falls:
            for name in ("alive", "upright", "lean", "riding_height"):
                if (term := self._known(name)) is not None:
                    weight = 1.6 * composition.weights.get(name, middle(term))
                    steadier = composition.with_term(term, weight)
                    yield Change(steadier, "the robot falls, so more weight on stability", 1.5)
        speed = moved.get("forward_speed_m_s", math.inf)
        if not self._sampler.robot.jumps and speed < SLOW and not falls:
            for name in ("early_progress", "activity"):
                if (term := self._known(name)) is not None and name not in composition.weights:
                    moving = composition.with_term(term, term.high)
                    yield Change(moving, "the robot stands still, so a term for motion", 2.0)
            lead = composition.lead
            if lead is not None:
                # Early in training, a small reward has no effect beside the policy's entropy bonus.
                larger = composition.with_term(lead, 2 * composition.weights[lead.name])
                yield Change(larger, "the robot stands still, so more weight on the task", 2.0)
            standing = [t.name for t in composition.terms if t.part in ("survival", "cost")]
            if standing:
                freer = _scaled(composition, standing, 0.4)
                reason = "the robot stands still, so less weight on survival and costs"
                yield Change(freer, reason, 2.0)
        if moved.get("mean_jerk", 0.0) > JERKY:
            term = self._known("jerkiness")
            if term is not None and "jerkiness" not in composition.weights:
                smoother = composition.with_term(term, middle(term))
                reason = "the actions are jerky, so a cost for changes of the action"
                yield Change(smoother, reason, 1.0)

    def _corrections_of_balance(
        self, composition: RewardComposition, best: Evaluation
    ) -> Iterator[Change]:
        """Yield changes of terms that dominate the task, and of terms without effect."""
        sizes = {n: abs(best.terms[n].mean) for n in composition.weights if n in best.terms}
        lead = composition.lead
        if lead is None or not sizes.get(lead.name):
            return
        for name, size in sizes.items():
            share = size / sizes[lead.name]
            if name != lead.name and share > DOMINANT:
                lighter = _scaled(composition, [name], max(0.5 * DOMINANT / share, 0.25))
                against = f"({size:.2g} against {sizes[lead.name]:.2g})"
                yield Change(lighter, f"{name} dominated {lead.name} {against}", 3.0)
            elif name != lead.name and share < NEGLIGIBLE:
                without = composition.without([name])
                yield Change(without, f"{name} had no effect and is removed", 0.7)

    def _copies(
        self, composition: RewardComposition, best: Evaluation, history: Sequence[Evaluation]
    ) -> Iterator[Change]:
        """Yield terms of rewards that scored better than the mean of their morphologies."""
        # How much each reward raises the log score of its morphologies.
        gains = reward_effects(
            (e.design.morphology.parameters, e.design.reward.source, math.log(score))
            for e in history
            if (score := e.score(self._objective)) is not None and score > 0
        )
        for source, gain in gains.items():
            if gain <= 0 or source == best.design.reward.source:
                continue
            other = self._sampler.composition(source)
            mine, theirs = composition.weights, other.weights
            apart = [term for term in other.terms if mine.get(term.name) != theirs[term.name]]
            for term in apart:
                copied = composition.with_term(term, theirs[term.name])
                reason = f"{term.name} copied from a reward with a good score"
                yield Change(copied, reason, 1.5 * min(gain, 1) / len(apart))

    def _random_changes(
        self, composition: RewardComposition, random: np.random.Generator
    ) -> Iterator[Change]:
        """Yield random changes: another leading term, a new term, one term less, other weights."""
        for term in self._sampler.suitable:
            if term.name in composition.weights:
                continue
            drawn = composition.with_term(term, self._sampler.drawn_weight(term, random))
            if term.part == "task":
                count = max(len(self._sampler.leads) - 1, 1)
                yield Change(drawn, f"{term.name} as the leading term", 0.5 / count)
            else:
                yield Change(drawn, f"{term.name} added", 0.8 / len(self._sampler.suitable))
        for name in composition.weights:
            if composition.lead is not None and name != composition.lead.name:
                weight = 0.3 / len(composition.weights)
                yield Change(composition.without([name]), f"{name} removed", weight)
        yield Change(self._jittered(composition, random), "other weights", 0.5)

    def _known(self, name: str) -> Term | None:
        return next((term for term in self._sampler.suitable if term.name == name), None)

    def _jittered(
        self, composition: RewardComposition, random: np.random.Generator
    ) -> RewardComposition:
        for term in composition.terms:
            factor = math.exp(random.normal(0, 0.4))
            composition = composition.with_term(term, composition.weights[term.name] * factor)
        return composition


def _scaled(
    composition: RewardComposition, names: Sequence[str], factor: float
) -> RewardComposition:
    """Return the composition with some weights scaled, without terms that would become tiny."""
    for term in composition.terms:
        if term.name in names:
            weight = composition.weights[term.name] * factor
            if weight < term.low / 2:
                composition = composition.without([term.name])
            else:
                composition = composition.with_term(term, weight)
    return composition
