"""What the search asks of a designer, be it an LLM, an optimiser or a person."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from robomore.types import Evaluation, Morphology, Reward, Slot


class Designer(Protocol):
    """Proposes bodies and rewards, and improves on what was measured (paper, Alg. 1).

    Every method is a pure function of its arguments and of the seed that the designer was made
    with: the slot names the place in the run, so the order of calls does not matter. A designer
    may raise `ProposalFailed`; the search then asks for a fresh proposal in the same place.

    Attributes:
        name: as on the command line.
        provenance: one plain sentence on what makes the proposals ("No LLM was used: …").
        reflects: whether proposals look at earlier ones (Diversity Reflection) and so have to come
            one after the other; taken as true where a designer does not say.
    """

    name: str
    provenance: str
    reflects: bool

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        """Return a body that is good and far from all `earlier` ones (Diversity Reflection).

        Nothing is earlier for a designer that does not reflect.
        """
        ...

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        """Return a reward that is good and unlike all `earlier` ones (Diversity Reflection)."""
        ...

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        """Return a body to be tried with `best`'s reward; `history` holds all that was measured.

        Screening leaves evaluations of fewer training steps in it (`robomore.types.finished`).
        """
        ...

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        """Return a reward to be tried on `best`'s body; `history` holds all that was measured."""
        ...
