"""Ablations: the search as it is, with a designer that leaves out what is to be missed."""

from __future__ import annotations

from collections.abc import Sequence

from robomore.designers.designer import Designer
from robomore.errors import ProposalFailed
from robomore.search.method import SearchContext
from robomore.search.population import kept_morphology
from robomore.search.robomore.settings import Part, RoboMoReSettings
from robomore.types import Evaluation, Morphology, Reward, Slot


def ablated(designer: Designer, settings: RoboMoReSettings, context: SearchContext) -> Designer:
    """Return `designer`, or one that proposes without the parts that the settings leave out."""
    if not settings.without:
        return designer
    kept = kept_morphology(context) if "morphology" in settings.without else None
    return _Ablated(designer, settings.without, kept)


class _Ablated:
    def __init__(
        self, designer: Designer, without: Sequence[Part], kept: Morphology | None
    ) -> None:
        self.name = designer.name
        self.provenance = designer.provenance
        self.reflects = "diversity" not in without and designer.reflects
        self._designer = designer
        self._without = without
        self._kept = kept

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        if self._kept is not None:
            return self._kept
        return self._designer.propose_morphology(slot, earlier if self.reflects else ())

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        return self._designer.propose_reward(slot, earlier if self.reflects else ())

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        if self._kept is not None:
            raise ProposalFailed("the search is without morphology, so it keeps the reference's")
        return self._designer.improve_morphology(slot, best, history)

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        if "reward" in self._without:
            raise ProposalFailed("the search is without reward, so it keeps the reference's")
        return self._designer.improve_reward(slot, best, history)
