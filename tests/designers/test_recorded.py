"""Proposals are remembered by slot and input, and failed slots are filled afresh."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from robomore.designers.recorded import RecordedDesigner
from robomore.errors import ProposalFailed
from robomore.events import Event, Proposed
from robomore.store import Ledger
from robomore.types import Evaluation, Morphology, Reward, Slot

SLOT = Slot("coarse", "morphology", (0,))


class Moody:
    """Fails in chosen attempts and never says the same twice."""

    name = "moody"
    reflects = True
    provenance = "No LLM was used."

    def __init__(self, failing: Sequence[int] = ()) -> None:
        self.failing = failing
        self.asked: list[Slot] = []

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        self.asked.append(slot)
        if slot.attempt in self.failing:
            raise ProposalFailed(f"not in the mood ({slot.attempt})")
        return Morphology((float(len(self.asked)),), "an idea")

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        self.asked.append(slot)
        return Reward(f"# {len(self.asked)}")

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        raise AssertionError("not asked here")

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        raise AssertionError("not asked here")


def test_the_same_slot_and_input_is_answered_from_the_ledger(tmp_path: Path) -> None:
    moody, ledger = Moody(), Ledger(tmp_path / "ledger.sqlite")
    first = RecordedDesigner(moody, ledger).propose_morphology(SLOT, [])
    again = RecordedDesigner(moody, ledger).propose_morphology(SLOT, [])
    assert first == again and len(moody.asked) == 1
    other = RecordedDesigner(moody, ledger).propose_morphology(SLOT, [Morphology((1.0,))])
    assert other != first and len(moody.asked) == 2


def test_a_failed_slot_is_recorded_and_filled_by_a_fresh_proposal(tmp_path: Path) -> None:
    seen: list[Event] = []
    ledger = Ledger(tmp_path / "ledger.sqlite")
    designer = RecordedDesigner(Moody(failing=[0, 1]), ledger, seen.append)
    assert designer.propose_morphology(SLOT, []).parameters == (3.0,)
    assert [p.failure for p in ledger.proposals()] == [
        "not in the mood (0)",
        "not in the mood (1)",
        "",
    ]
    assert [e.slot.attempt for e in seen if isinstance(e, Proposed)] == [0, 1, 2]


def test_failures_are_remembered_too(tmp_path: Path) -> None:
    moody, ledger = Moody(failing=[0]), Ledger(tmp_path / "ledger.sqlite")
    RecordedDesigner(moody, ledger).propose_morphology(SLOT, [])
    RecordedDesigner(moody, ledger).propose_morphology(SLOT, [])
    assert [slot.attempt for slot in moody.asked] == [0, 1]


def test_out_of_attempts_the_reason_is_told(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path / "ledger.sqlite")
    designer = RecordedDesigner(Moody(failing=[0, 1, 2]), ledger)
    with pytest.raises(ProposalFailed, match=r"morphology 1 in 3 attempts.*not in the mood \(2\)"):
        designer.propose_morphology(SLOT, [])
