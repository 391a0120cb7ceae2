"""A person's remarks: from the command, from a file between requests, kept for each slot."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

import pytest

from robomore.designers.hints import MOST_CHARACTERS, Hints
from robomore.designers.recorded import RecordedDesigner
from robomore.store import Ledger, RunFolder
from robomore.types import Morphology, Slot

FIRST, SECOND = (Slot("coarse", "morphology", (index,)) for index in (0, 1))


@pytest.fixture
def ledger(tmp_path: Path) -> Iterator[Ledger]:
    with closing(Ledger(tmp_path / "ledger.sqlite")) as opened:
        yield opened


class Obedient:
    """Proposes the length of the remark that it was given."""

    name = "obedient"
    reflects = False
    provenance = "No LLM was used."

    def __init__(self, hint: str = "") -> None:
        self.hint = hint

    def with_hint(self, hint: str) -> Obedient:
        return Obedient(hint)

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        return Morphology((float(len(self.hint)),), self.hint)


def test_a_remark_reaches_the_designer_and_a_resumed_run_keeps_it(
    tmp_path: Path, ledger: Ledger
) -> None:
    folder = RunFolder(tmp_path)

    def proposed(text: str, slot: Slot) -> str:
        hints = Hints(text, folder, ledger)
        designer = RecordedDesigner(Obedient(), ledger, hint_for=hints.of)  # type: ignore[arg-type]
        return designer.propose_morphology(slot, ()).idea

    assert proposed("", FIRST) == ""
    folder.hint.write_text("longer legs\n", encoding="utf-8")
    assert proposed("", FIRST) == "", "what was proposed stays proposed"
    assert proposed("no wheels", SECOND).split() == ["no", "wheels", "longer", "legs"]
    folder.hint.unlink()
    assert Hints("other", folder, ledger).of(SECOND) == "no wheels\n\nlonger legs"
    assert list(ledger.hints().values()) == ["no wheels\n\nlonger legs"]


def test_a_file_that_cannot_be_used_is_a_warning(
    tmp_path: Path, ledger: Ledger, caplog: pytest.LogCaptureFixture
) -> None:
    folder = RunFolder(tmp_path)
    folder.hint.write_bytes(b"\xff\xfe\xff")
    hints = Hints("", folder, ledger)
    with caplog.at_level(logging.WARNING):
        assert hints.of(FIRST) == ""
    assert "hint.txt is not used" in caplog.text
    folder.hint.write_text("x" * (MOST_CHARACTERS + 1))
    assert hints.of(SECOND) == "x" * MOST_CHARACTERS
    assert "only the first" in caplog.text


def test_a_designer_that_reads_no_remarks_is_asked_as_ever(ledger: Ledger) -> None:
    class Deaf(Obedient):
        with_hint = None  # type: ignore[assignment]

    def none_asked(slot: Slot) -> str:
        raise AssertionError("nobody reads it")

    designer = RecordedDesigner(Deaf(), ledger, hint_for=none_asked)  # type: ignore[arg-type]
    assert designer.propose_morphology(FIRST, ()).parameters == (0.0,)
