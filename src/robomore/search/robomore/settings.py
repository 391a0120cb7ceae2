"""Sizes of the paper's search (paper, Table 6), and how its grid is screened."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated, Literal

import msgspec

from robomore.errors import InputError

Count = Annotated[int, msgspec.Meta(ge=1)]
Fraction = Annotated[float, msgspec.Meta(gt=0, le=1)]


Part = Literal["diversity", "coarse", "fine", "morphology", "reward"]


@dataclass(frozen=True, slots=True)
class Rung:
    """A stop on the way to a candidate's full training, where the worst are cut."""

    budget_fraction: Annotated[float, msgspec.Meta(gt=0, lt=1)]
    """Of the full steps, up to which everyone still in the race is trained."""
    keep_fraction: Fraction
    """Fraction of the grid's pairs that go on from here; at least one does."""


@dataclass(frozen=True, slots=True)
class RoboMoReSettings:
    """Options of the method `robomore`."""

    morphologies: Count = 25
    """Rows of the coarse grid (N_M)."""
    rewards: Count = 5
    """Columns of the coarse grid (N_R), the reference reward's among them if it is in."""
    reference_reward: Literal["in", "out"] = "in"
    """Whether the reference reward is one column of the grid and may win; the paper leaves it
    out."""
    first_morphologies: Literal["designer", "gaussian"] = "designer"
    """Where the rows of the grid come from: `gaussian` draws them around the reference morphology,
    as the paper's Random Sample does; the rewards stay the designer's."""
    slim_reference: Literal["in", "out"] = "out"
    """Whether the reference morphology, as thin as its search rules allow, is one row of the grid;
    the paper leaves it out. It is what a search for efficiency has to beat."""
    survivors: Fraction = 0.05
    """Fraction of the grid that the fine stage starts from (k); at least one design."""
    max_cycles: Annotated[int, msgspec.Meta(ge=0)] = 10
    """Most cycles of the fine stage. The paper stops only when a cycle improved nothing."""
    patience: Count = 1
    """Cycles in a row without improvement after which a branch ends, if both a morphology and a
    reward were tried on its best; 1 in the paper. With more, a branch that had bad luck once goes
    on, with smaller steps, while the budget lasts."""
    order: Literal["alternate", "adaptive"] = "alternate"
    """Whose turn it is in the fine stage: `alternate` improves the morphology, then the reward, as
    the paper does; `adaptive` improves what improved more lately. A cycle has two turns."""
    improvement: Literal["score", "seeds"] = "score"
    """When a proposal of the fine stage counts as better: `score` compares one training each, as
    the paper does; `seeds` trains both designs with a second seed if the call is close, and
    compares the means. That costs up to twice the trainings of the fine stage."""
    close_call: Fraction = 0.2
    """With seeds: relative difference of two scores up to which a call is close. Once a branch has
    measured two designs twice, the difference between their seeds takes its place."""
    screening: Literal["none", "halving"] = "none"
    """How the grid is thinned out: `none` trains every pair to the end, as the paper does;
    `halving` cuts the worst on the way (successive halving)."""
    rungs: tuple[Rung, ...] = (Rung(0.2, 0.2), Rung(0.4, 0.08))
    """With halving: where is cut. What is kept at the last rung is trained to the end."""
    without: tuple[Part, ...] = ()
    """Ablations: parts that are left out. Without `diversity`, proposals do not see earlier ones;
    without `coarse`, the grid is one pair; without `fine`, nothing is refined; without
    `morphology` or `reward`, that half stays the reference's. Screening is left out by its own
    option."""

    @property
    def reduced(self) -> RoboMoReSettings:
        """These settings with the sizes that are left of them without the ablated parts.

        Without the coarse stage, the one pair is a proposed one, where something is proposed.
        """
        one_row = {"coarse", "morphology"}.intersection(self.without)
        one_column = {"coarse", "reward"}.intersection(self.without)
        reward = "out" if "coarse" in self.without else self.reference_reward
        return replace(
            self,
            morphologies=1 if one_row else self.morphologies,
            rewards=1 if one_column else self.rewards,
            reference_reward="in" if "reward" in self.without else reward,
            slim_reference="out" if one_row else self.slim_reference,
            max_cycles=0 if "fine" in self.without else self.max_cycles,
            screening="none" if one_row and one_column else self.screening,
        )

    @property
    def proposed_morphologies(self) -> int:
        """Rows of the grid that the designer fills."""
        return self._first_morphologies if self.first_morphologies == "designer" else 0

    @property
    def drawn_morphologies(self) -> int:
        """Rows of the grid that are drawn."""
        return self._first_morphologies if self.first_morphologies == "gaussian" else 0

    @property
    def _first_morphologies(self) -> int:
        return self.morphologies - (self.slim_reference == "in")

    @property
    def proposed_rewards(self) -> int:
        """Columns of the grid that the designer fills."""
        return self.rewards - (self.reference_reward == "in")

    def check(self) -> None:
        """Refuse rungs and ablations that make no sense.

        Raises:
            InputError: naming the value, the range and the remedy.
        """
        if {"morphology", "reward"} <= {*self.without}:
            raise InputError(
                f"without = {list(self.without)} leaves nothing to search; keep the morphology or "
                "the reward, or choose --method reference"
            )
        if self.first_morphologies == "gaussian" and "morphology" in self.without:
            raise InputError(
                "without = ['morphology'] keeps the reference morphology, and first_morphologies = "
                "'gaussian' draws others; leave one of them out"
            )
        for first, second in pairwise(self.rungs):
            if not (
                first.budget_fraction < second.budget_fraction
                and first.keep_fraction >= second.keep_fraction
            ):
                raise InputError(
                    f"{second} comes after {first}: budget_fraction has to rise from rung to rung, "
                    "and keep_fraction must not"
                )
