"""First proposals: rewards in which the task leads, each made of other terms than the last."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from robomore.designers.offline.reward_composition import (
    STYLES,
    RewardComposition,
    guessed,
    read,
    rounded,
)
from robomore.designers.offline.reward_term import Term
from robomore.designers.offline.reward_terms import suitable
from robomore.designers.offline.robot_semantics import Anatomy, anatomy
from robomore.errors import ProposalFailed
from robomore.identity import derive_seed
from robomore.tasks.task import Task
from robomore.types import Reward, Slot

DRAWS = 60
"""Recipes that a proposal is chosen from."""


class RewardSampler:
    """Composes rewards for one task (paper, Sec. 4.1, Diversity Reflection) without an LLM."""

    def __init__(self, task: Task, seed: int) -> None:
        self._task = task
        self._seed = seed
        self.body: Anatomy = anatomy(task)
        self.suitable = suitable(self.body)
        self.leads = [term for term in self.suitable if term.part == "task"]

    def propose(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        """Return the most different of some sane rewards; without `earlier` ones, a plain one.

        Raises:
            ProposalFailed: no term is known that asks for the task, or no draw is new.
        """
        if not self.leads:
            raise ProposalFailed(f"{self._task.id}: no reward term for this robot's task is known")
        random = np.random.default_rng(derive_seed(self._seed, "reward", slot))
        known = {reward.source for reward in earlier}
        others = [self.recipe(reward.source) for reward in earlier]
        if not others and slot.attempt == 0:
            draws = [self._plain(random)]
        else:
            draws = [self._drawn(random) for _ in range(DRAWS)]
        fresh = [draw for draw in draws if draw.source(self.body) not in known]
        if not fresh:
            raise ProposalFailed(f"{self._task.id}: no reward was found that is not there already")
        best = max(fresh, key=lambda draw: _novelty(draw, others))
        return Reward(best.source(self.body), best.idea())

    def recipe(self, source: str) -> RewardComposition:
        """Return the recipe of one of our texts, or the nearest one to anybody else's."""
        return read(source, self.body) or guessed(source, self.suitable)

    def drawn_weight(self, term: Term, random: np.random.Generator) -> float:
        """Return a weight from the term's range, uniform in its logarithm."""
        return rounded(math.exp(random.uniform(math.log(term.low), math.log(term.high))))

    def _plain(self, random: np.random.Generator) -> RewardComposition:
        """Return what everybody starts with: the task, staying alive, little effort."""
        chosen = [self.leads[0]]
        chosen += [term for term in self.suitable if term.part == "survival"]
        chosen += [term for term in self.suitable if term.topic == "effort"][:1]
        return RewardComposition({term.name: self.drawn_weight(term, random) for term in chosen})

    def _drawn(self, random: np.random.Generator) -> RewardComposition:
        """Return a random sane recipe: one leading term, one to three bonuses, one or two costs."""
        recipe = RewardComposition({}, STYLES[random.integers(len(STYLES))])
        lead = self.leads[random.integers(len(self.leads))]
        recipe = recipe.having(lead, self.drawn_weight(lead, random))
        for part, count in (
            ("survival", int(random.random() < 0.9)),
            ("bonus", random.integers(1, 4)),
            ("cost", random.integers(1, 3)),
        ):
            pool = [term for term in self.suitable if term.part == part]
            for i in random.permutation(len(pool))[:count]:
                if pool[i].topic not in {term.topic for term in recipe.terms}:
                    recipe = recipe.having(pool[i], self.drawn_weight(pool[i], random))
        return led(recipe)


def led(recipe: RewardComposition) -> RewardComposition:
    """Return the recipe with bonuses damped where they could outweigh the task together.

    What a robot gets for standing there (survival and bonuses at their largest) must stay below
    what it gets for a moderate speed or height.
    """
    lead = recipe.lead
    standing = [term for term in recipe.terms if term.part in ("survival", "bonus")]
    total = sum(recipe.weights[term.name] for term in standing)
    if lead is None or total <= recipe.weights[lead.name]:
        return recipe
    share = recipe.weights[lead.name] / total
    for term in standing:
        recipe = RewardComposition(
            {**recipe.weights, term.name: rounded(recipe.weights[term.name] * share)}, recipe.style
        )
    return recipe


def _novelty(recipe: RewardComposition, others: Sequence[RewardComposition]) -> float:
    """Return how unlike the nearest of `others` a recipe is."""
    return min((_unlike(recipe, other) for other in others), default=1.0)


def _unlike(one: RewardComposition, other: RewardComposition) -> float:
    """Return the Jaccard distance of the terms, and a little for weights and style.

    Staying alive is no difference: a robot that can fall needs it in nearly every reward.
    """
    mine, theirs = ({t.name for t in r.terms if t.part != "survival"} for r in (one, other))
    shared = mine & theirs
    apart = 1 - len(shared) / len(mine | theirs)
    weights = sum(abs(math.log(one.weights[n] / other.weights[n])) for n in shared)
    return apart + 0.05 * (one.style != other.style) + 0.05 * min(weights / 5, 1)
