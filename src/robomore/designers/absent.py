"""The designer of search methods that need none."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NoReturn

from robomore.errors import ProposalFailed
from robomore.types import Evaluation, Morphology, Reward, Slot


class NoDesigner:
    """Has no proposals. A method gets it if it says that it needs no designer."""

    name = ""
    reflects = False

    def __init__(self, provenance: str) -> None:
        self.provenance = provenance

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        """Refuse; see `Designer.propose_morphology`."""
        return self._refuse(slot)

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        """Refuse; see `Designer.propose_reward`."""
        return self._refuse(slot)

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        """Refuse; see `Designer.improve_morphology`."""
        return self._refuse(slot)

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        """Refuse; see `Designer.improve_reward`."""
        return self._refuse(slot)

    def _refuse(self, slot: Slot) -> NoReturn:
        raise ProposalFailed(f"the {slot} was asked for, but the method says it needs no designer")
