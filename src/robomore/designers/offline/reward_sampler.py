"""Proposes rewards with a leading term for the task, each made of other terms than the earlier."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from robomore.designers.offline.reward_composition import (
    STYLES,
    RewardComposition,
    guess_composition,
    middle,
    parse_composition,
    rounded,
)
from robomore.designers.offline.reward_terms import Term, suitable
from robomore.designers.offline.robot_semantics import robot_semantics
from robomore.errors import ProposalFailed
from robomore.identity import derive_seed
from robomore.tasks.task import Task
from robomore.types import Reward, Slot

DRAWS = 60
"""Compositions that a proposal is chosen from."""


class RewardSampler:
    """Composes rewards for one task (paper, Sec. 4.1, Diversity Reflection) without an LLM."""

    def __init__(self, task: Task, seed: int) -> None:
        self._task = task
        self._seed = seed
        self.robot = robot_semantics(task)
        self.suitable = suitable(self.robot)
        self.leads = [term for term in self.suitable if term.part == "task"]

    def sample(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        """Return the most different of several random rewards, or a plain one if it is the first.

        Raises:
            ProposalFailed: no term for the task itself suits the robot, or no sample is new.
        """
        if not self.leads:
            raise ProposalFailed(f"{self._task.id}: no reward term for this robot's task is known")
        random = np.random.default_rng(derive_seed(self._seed, "reward", slot))
        known = {reward.source for reward in earlier}
        others = [self.composition(reward.source) for reward in earlier]
        first = not others and slot.attempt == 0 and not any(slot.index)
        draws = [self._plain()] if first else [self._drawn(random) for _ in range(DRAWS)]
        fresh = [draw for draw in draws if draw.source(self.robot) not in known]
        if not fresh:
            raise ProposalFailed(f"{self._task.id}: no new reward was found")
        best = max(fresh, key=lambda draw: min((_distance(draw, o) for o in others), default=1.0))
        return Reward(best.source(self.robot), best.idea())

    def composition(self, source: str) -> RewardComposition:
        """Return the composition of a text of this class, or the nearest one to any other text."""
        return parse_composition(source, self.robot) or guess_composition(source, self.suitable)

    def drawn_weight(self, term: Term, random: np.random.Generator) -> float:
        """Return a random weight from the term's range, uniform in its logarithm."""
        return rounded(math.exp(random.uniform(math.log(term.low), math.log(term.high))))

    def _plain(self) -> RewardComposition:
        """Return the usual first reward: the task itself, a little survival, and little effort."""
        chosen = [self.leads[0]]
        chosen += [term for term in self.suitable if term.part == "survival"]
        chosen += [term for term in self.suitable if term.topic == "effort"][:1]
        return RewardComposition({term.name: middle(term) for term in chosen})

    def _drawn(self, random: np.random.Generator) -> RewardComposition:
        """Return a random composition: one leading term, up to three bonuses, up to two costs."""
        composition = RewardComposition({}, STYLES[random.integers(len(STYLES))])
        lead = self.leads[random.integers(len(self.leads))]
        composition = composition.with_term(lead, self.drawn_weight(lead, random))
        for part, count in (
            ("survival", int(random.random() < 0.9)),
            ("bonus", random.integers(1, 4)),
            ("cost", random.integers(1, 3)),
        ):
            pool = [term for term in self.suitable if term.part == part]
            for i in random.permutation(len(pool))[:count]:
                if pool[i].topic not in {term.topic for term in composition.terms}:
                    composition = composition.with_term(pool[i], self.drawn_weight(pool[i], random))
        return damped(composition)


def damped(composition: RewardComposition) -> RewardComposition:
    """Return the composition with smaller bonuses, if all bonuses together outweigh the task.

    The largest reward for standing still (survival and bonuses) must stay below the reward for a
    moderate speed or height.
    """
    lead = composition.lead
    standing = [term for term in composition.terms if term.part in ("survival", "bonus")]
    total = sum(composition.weights[term.name] for term in standing)
    if lead is None or total <= composition.weights[lead.name]:
        return composition
    share = composition.weights[lead.name] / total
    for term in standing:
        composition = RewardComposition(
            {**composition.weights, term.name: rounded(composition.weights[term.name] * share)},
            composition.style,
        )
    return composition


def _distance(one: RewardComposition, other: RewardComposition) -> float:
    """Return the Jaccard distance of the terms, plus a little for the weights and the style.

    Survival does not count, because nearly every reward of a robot that can fall has it.
    """
    mine, theirs = ({t.name for t in r.terms if t.part != "survival"} for r in (one, other))
    shared = mine & theirs
    apart = 1 - len(shared) / len(mine | theirs)
    weights = sum(abs(math.log(one.weights[n] / other.weights[n])) for n in shared)
    return apart + 0.05 * (one.style != other.style) + 0.05 * min(weights / 5, 1)
