"""The ledger keeps what it is given, finds damage, and refuses what it cannot read."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

from robomore.errors import LedgerError
from robomore.store.ledger import Ledger, Proposal
from robomore.types import (
    Design,
    Evaluation,
    Job,
    Morphology,
    Place,
    Reward,
    Slot,
    Status,
    TermStatistics,
    TrainerSettings,
)

DESIGN = Design(Morphology((0.1, 1 / 3), "thin"), Reward("def _get_rew(): ...", "fast"))
JOB = Job("ant", DESIGN, TrainerSettings("crossq", {"hidden": [8]}), 100, 2, 7)
GOOD = Evaluation(
    "k1",
    JOB,
    Status.OK,
    fitness=1.1,
    volume=0.1,
    efficiency=11.000000000000002,
    episode_fitness=(1.0, 1.2),
    terms={"speed": TermStatistics(1.0, 0.0, 2.0)},
    notes=("a note",),
)
BAD = Evaluation("k2", JOB, Status.REWARD_FAILED, "line 3: NameError")


def test_evaluations_come_back_to_the_last_bit(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path / "ledger.sqlite")
    ledger.add_evaluation(GOOD)
    ledger.add_evaluation(BAD)
    ledger.close()
    again = Ledger(tmp_path / "ledger.sqlite", read_only=True)
    assert again.evaluations() == [GOOD, BAD]
    assert again.evaluation("k1") == GOOD
    assert again.evaluation("none") is None


def test_places_come_back_in_the_order_of_asking_and_share_evaluations(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path / "ledger.sqlite")
    first, second = Place(stage="coarse", morphology=3), Place(stage="fine", branch=1)
    ledger.add_place(first, "k1")
    ledger.add_place(second, "k1")
    ledger.add_place(Place(stage="fine", branch=2), "running")
    ledger.add_evaluation(GOOD)
    assert ledger.placed() == [(first, GOOD), (second, GOOD)]


def test_a_proposal_is_found_only_for_the_same_input(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path / "ledger.sqlite")
    proposal = Proposal(Slot("coarse", "morphology", 0, 0), morphology=DESIGN.morphology)
    ledger.add_proposal(proposal, given="abc")
    assert ledger.proposal(proposal.slot, "abc") == proposal
    assert ledger.proposal(proposal.slot, "other") is None
    assert ledger.proposal(Slot("coarse", "morphology", 0, 1), "abc") is None


def test_a_changed_row_is_refused_not_believed(tmp_path: Path) -> None:
    path = tmp_path / "ledger.sqlite"
    ledger = Ledger(path)
    ledger.add_evaluation(GOOD)
    ledger.close()
    with sqlite3.connect(path) as db:
        db.execute("UPDATE evaluations SET body = CAST(replace(body, '11.0', '99.0') AS BLOB)")
    with pytest.raises(LedgerError, match=r"digest.*same command"):
        Ledger(path)


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE evaluations SET key = 'k3' WHERE key = 'k1'",
        "UPDATE evaluations SET time = time + 1",
        "UPDATE places SET place = replace(place, ':3', ':4')",
        "UPDATE places SET evaluation = 'k2'",
        "UPDATE places SET seq = 7",
        "UPDATE proposals SET given = 'other'",
        "UPDATE events SET kind = 'finished'",
        "UPDATE events SET seq = 9",
    ],
)
def test_every_column_is_under_the_digest(tmp_path: Path, change: str) -> None:
    path = tmp_path / "ledger.sqlite"
    ledger = Ledger(path)
    ledger.add_evaluation(GOOD)
    ledger.add_place(Place(stage="coarse", morphology=3), "k1")
    ledger.add_proposal(Proposal(Slot("coarse", "morphology", 0, 0), DESIGN.morphology), "abc")
    ledger.add_event("interrupted")
    ledger.close()
    with sqlite3.connect(path) as db:
        assert db.execute(change).rowcount == 1
    for read_only in (False, True):
        with pytest.raises(LedgerError, match="digest"):
            Ledger(path, read_only)


def test_a_file_that_is_no_ledger_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "ledger.sqlite"
    path.write_bytes(b"this is not a database" * 100)
    with pytest.raises(LedgerError, match="is not a database"):
        Ledger(path)


def test_a_newer_ledger_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "ledger.sqlite"
    Ledger(path).close()
    with sqlite3.connect(path) as db:
        db.execute("PRAGMA user_version = 99")
    with pytest.raises(LedgerError, match=r"version 99.*newer"):
        Ledger(path)


def test_an_older_ledger_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "ledger.sqlite"
    Ledger(path).close()
    with sqlite3.connect(path) as db:
        db.execute("PRAGMA user_version = 1")
    with pytest.raises(LedgerError, match=r"version 1.*the RoboMoRe that wrote it"):
        Ledger(path)


def test_events_keep_their_order(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path / "ledger.sqlite")
    ledger.add_event("one", n=1)
    ledger.add_event("two")
    assert [(event.kind, event.body) for event in ledger.events()] == [
        ("one", {"n": 1}),
        ("two", {}),
    ]
