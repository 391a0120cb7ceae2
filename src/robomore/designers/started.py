"""A designer whose first proposals are those that a person gave."""

from __future__ import annotations

from collections.abc import Sequence

from robomore.designers.designer import Designer
from robomore.types import Evaluation, Morphology, Reward, Slot


class StartedDesigner:
    """A designer whose first proposals are given ones; all others are the designer's own."""

    def __init__(
        self,
        designer: Designer,
        morphologies: Sequence[Morphology],
        rewards: Sequence[Reward],
    ) -> None:
        self.name = designer.name
        self.provenance = designer.provenance
        self.reflects = getattr(designer, "reflects", True)
        self._designer = designer
        self._morphologies = tuple(morphologies)
        self._rewards = tuple(rewards)

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        """Return the given morphology of this slot, or the designer's proposal."""
        if slot.index[-1] < len(self._morphologies):
            return self._morphologies[slot.index[-1]]
        return self._designer.propose_morphology(slot, earlier)

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        """Return the given reward of this slot, or the designer's proposal."""
        if slot.index[-1] < len(self._rewards):
            return self._rewards[slot.index[-1]]
        return self._designer.propose_reward(slot, earlier)

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        """Return the designer's own proposal."""
        return self._designer.improve_morphology(slot, best, history)

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        """Return the designer's own proposal."""
        return self._designer.improve_reward(slot, best, history)

    def with_hint(self, hint: str) -> Designer:
        """Return the same with a person's remark for the designer, if it reads remarks."""
        told = getattr(self._designer, "with_hint", None)
        return (
            self if told is None else StartedDesigner(told(hint), self._morphologies, self._rewards)
        )
