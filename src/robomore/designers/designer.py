"""The interface of a designer: a language model, an optimizer or a person."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from robomore.types import Evaluation, Morphology, Reward, Slot


class Designer(Protocol):
    """Proposes morphologies and rewards, and improves on what was measured (paper, Alg. 1).

    Every method is a pure function of its arguments and of the seed that the designer was made
    with. The slot names the proposal within the run, so the order of calls does not matter. A
    designer may raise `ProposalFailed`; the search then asks again with the next attempt of the
    same slot. `robomore.testing.check_designer` checks all of this.

    Attributes:
        name: name on the command line.
        provenance: one plain sentence on what makes the proposals ("No LLM was used: …").
        reflects: whether proposals depend on earlier ones (Diversity Reflection). If so, they are
            asked for one after the other. A designer without this attribute counts as one that
            reflects.
    """

    name: str
    provenance: str
    reflects: bool

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        """Return a good morphology that is far from all `earlier` ones (Diversity Reflection).

        `earlier` is empty for a designer that does not reflect.
        """
        ...

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        """Return a good reward that is unlike all `earlier` ones (Diversity Reflection)."""
        ...

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        """Return a morphology to try with `best`'s reward.

        `history` holds all evaluations so far. Screening leaves some with fewer training steps
        (`robomore.types.finished`).
        """
        ...

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        """Return a reward to try with `best`'s morphology. `history` is as above."""
        ...
