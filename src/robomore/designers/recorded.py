"""Records the proposals of a designer, so that a resumed run asks for none of them twice."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from robomore.designers.designer import Designer
from robomore.designers.hints import no_hint
from robomore.errors import ProposalFailed, TimeLimitReached
from robomore.events import Observer, Proposed, ignore
from robomore.identity import content_key
from robomore.store.ledger import Ledger
from robomore.store.schema import Proposal
from robomore.types import Evaluation, Morphology, Reward, Slot

ATTEMPTS = 3
"""How often a slot is asked for before it stays empty."""


class RecordedDesigner:
    """Answers from the ledger, or else asks `designer` and records the answer in the ledger.

    A failed proposal is recorded too, and the designer is asked again with the slot's next attempt.
    When all attempts fail, `ProposalFailed` is raised and the slot stays empty. Several threads may
    use it at once.
    """

    def __init__(
        self,
        designer: Designer,
        ledger: Ledger,
        observe: Observer = ignore,
        time_is_up: Callable[[], bool] = lambda: False,
        hint_for: Callable[[Slot], str] = no_hint,
    ) -> None:
        self.name = designer.name
        self.provenance = designer.provenance
        self.reflects = getattr(designer, "reflects", True)
        self._designer = designer
        self._ledger = ledger
        self._observe = observe
        self._time_is_up = time_is_up
        self._hint_for = hint_for

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        """See `Designer.propose_morphology`."""
        given = content_key([morphology.parameters for morphology in earlier])
        return self._morphology(slot, given, "propose_morphology", earlier)

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        """See `Designer.propose_reward`."""
        given = content_key([reward.source for reward in earlier])
        return self._reward(slot, given, "propose_reward", earlier)

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        """See `Designer.improve_morphology`."""
        given = content_key(best.key, [evaluation.key for evaluation in history])
        return self._morphology(slot, given, "improve_morphology", best, history)

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        """See `Designer.improve_reward`."""
        given = content_key(best.key, [evaluation.key for evaluation in history])
        return self._reward(slot, given, "improve_reward", best, history)

    def _morphology(self, slot: Slot, given: str, method: str, *known: object) -> Morphology:
        def ask(slot: Slot) -> Proposal:
            return Proposal(slot, getattr(self._told(slot), method)(slot, *known))

        proposal = self._fill(slot, given, ask)
        assert proposal.morphology is not None
        return proposal.morphology

    def _reward(self, slot: Slot, given: str, method: str, *known: object) -> Reward:
        def ask(slot: Slot) -> Proposal:
            return Proposal(slot, reward=getattr(self._told(slot), method)(slot, *known))

        proposal = self._fill(slot, given, ask)
        assert proposal.reward is not None
        return proposal.reward

    def _told(self, slot: Slot) -> Designer:
        """Return the designer with the person's remark for this slot, if it reads remarks."""
        with_hint = getattr(self._designer, "with_hint", None)
        hint = self._hint_for(slot) if with_hint else ""
        told: Designer = with_hint(hint) if with_hint and hint else self._designer
        return told

    def _fill(self, slot: Slot, given: str, ask: Callable[[Slot], Proposal]) -> Proposal:
        failure = ""
        for attempt in range(ATTEMPTS):
            fresh = replace(slot, attempt=attempt)
            proposal = self._ledger.proposal(fresh, given)
            if proposal is None:
                if self._time_is_up():
                    raise TimeLimitReached(f"the {slot} was not asked for any more")
                try:
                    proposal = ask(fresh)
                except ProposalFailed as error:
                    proposal = Proposal(fresh, failure=str(error))
                self._ledger.add_proposal(proposal, given)
            failure = proposal.failure
            proposed = proposal.morphology or proposal.reward
            self._observe(Proposed(fresh, proposed.idea if proposed else "", failure))
            if proposed is not None:
                return proposal
        raise ProposalFailed(
            f"{self.name} could not fill the {slot} in {ATTEMPTS} attempts; the last one: {failure}"
        )
