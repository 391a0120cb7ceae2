"""The ledger keeps what it is given, finds damage, and refuses what it cannot read."""

from __future__ import annotations

import sqlite3
import zlib
from dataclasses import replace
from pathlib import Path

import pytest

from robomore.errors import LedgerError
from robomore.store.ledger import Ledger
from robomore.store.recovery import open_or_recover
from robomore.store.rows import digest
from robomore.store.schema import Proposal
from robomore.types import (
    Curve,
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
JOB = Job("ant", DESIGN, TrainerSettings("crossq", {"net_arch": [8]}), 100, 2, 7)
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


def test_curves_are_kept_apart_and_small(tmp_path: Path) -> None:
    path = tmp_path / "ledger.sqlite"
    ledger = Ledger(path)
    steps = tuple(range(128, 128 * 51, 128))
    values = tuple(0.1 * n for n in range(50))
    curve = Curve(steps, {"episode_return": values, "alpha": (None, *values[1:])})
    ledger.add_evaluation(replace(GOOD, curve=curve))
    assert ledger.evaluation("k1") == GOOD
    assert ledger.curve("k1") == curve
    assert ledger.curve("k2") is None
    with sqlite3.connect(path) as db:
        ((size,),) = db.execute("SELECT length(body) FROM curves")
    assert size < 1_000


def test_a_curve_that_unpacks_to_more_than_any_can_be_is_refused(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path / "ledger.sqlite")
    row = ("k1", zlib.compress(b" " * 2**26), 0.0)
    ledger.restore("curves", (*row, digest(row)))
    with pytest.raises(LedgerError, match="longer than any"):
        ledger.curve("k1")


def test_places_come_back_in_the_order_of_asking_and_share_evaluations(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path / "ledger.sqlite")
    first, second = Place(stage="coarse", index=(3,)), Place(stage="fine", index=(1,))
    ledger.add_place(first, "k1")
    ledger.add_place(second, "k1")
    ledger.add_place(Place(stage="fine", index=(2,)), "running")
    ledger.add_evaluation(GOOD)
    assert ledger.placed() == [(first, GOOD), (second, GOOD)]


def test_a_proposal_is_found_only_for_the_same_input(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path / "ledger.sqlite")
    proposal = Proposal(Slot("coarse", "morphology", (0,)), morphology=DESIGN.morphology)
    ledger.add_proposal(proposal, given="abc")
    assert ledger.proposal(proposal.slot, "abc") == proposal
    assert ledger.proposal(proposal.slot, "other") is None
    assert ledger.proposal(Slot("coarse", "morphology", (1,)), "abc") is None


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
        "UPDATE curves SET key = 'k2'",
        "UPDATE places SET place = replace(place, '[3]', '[4]')",
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
    ledger.add_evaluation(replace(GOOD, curve=Curve((1,), {"alpha": (0.5,)})))
    ledger.add_place(Place(stage="coarse", index=(3,)), "k1")
    ledger.add_proposal(Proposal(Slot("coarse", "morphology", (0,)), DESIGN.morphology), "abc")
    ledger.add_event("interrupted")
    ledger.close()
    with sqlite3.connect(path) as db:
        assert db.execute(change).rowcount == 1
    for read_only in (False, True):
        with pytest.raises(LedgerError, match="digest"):
            Ledger(path, read_only)


@pytest.mark.parametrize(
    ("change", "lost"),
    [
        ("UPDATE evaluations SET body = CAST(replace(body, '11.0', '99.0') AS BLOB)", "evaluation"),
        ("UPDATE proposals SET body = CAST(replace(body, 'thin', 'thick') AS BLOB)", "proposal"),
        ("UPDATE events SET kind = 'finished'", "event"),
        ("UPDATE places SET evaluation = 'k2' WHERE seq = 2", "place"),
    ],
)
def test_only_rows_that_agree_with_their_digest_are_recovered(
    tmp_path: Path, change: str, lost: str
) -> None:
    """What was changed can still be read, and nothing else would notice."""
    path = tmp_path / "ledger.sqlite"
    ledger = Ledger(path)
    ledger.add_evaluation(GOOD)
    ledger.add_evaluation(replace(GOOD, key="k2", fitness=0.5, efficiency=5.0))
    for index, key in enumerate(("k2", "k1")):
        ledger.add_place(Place(stage="coarse", index=(index,)), key)
    ledger.add_proposal(Proposal(Slot("coarse", "morphology", (0,)), DESIGN.morphology), "abc")
    ledger.add_event("interrupted")
    ledger.close()
    with sqlite3.connect(path) as db:
        assert db.execute(change).rowcount > 0
    found = open_or_recover(path)
    kept = {
        "evaluation": [one.key for one in found.evaluations()] == ["k1", "k2"],
        "proposal": len(found.proposals()) == 1,
        "event": [one.kind for one in found.events()] == ["interrupted"],
        "place": len(found._execute("SELECT * FROM places")) == 2,
    }
    found.close()
    assert [name for name, whole in kept.items() if not whole] == [lost]


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
