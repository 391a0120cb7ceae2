"""Ledgers that somebody else wrote: no program in them runs, and no row stops a run for good."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from test_ledger import GOOD, JOB

from robomore.errors import LedgerDamaged, LedgerError
from robomore.llm import Exchange, Message, Sampling
from robomore.store import Ledger, LedgerExchanges, open_or_recover, rows
from robomore.store.rows import digest
from robomore.store.schema import TABLES, Proposal, check_numbers
from robomore.types import Evaluation, Morphology, Place, Reward, Slot, Status

ENDLESS = "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x FROM n) SELECT x FROM n"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    with closing(Ledger(tmp_path / "ledger.sqlite")) as ledger:
        ledger.add_evaluation(GOOD)
        ledger.add_place(Place(stage="coarse"), GOOD.key)
    return tmp_path / "ledger.sqlite"


@pytest.mark.parametrize(
    "program",
    [
        f"CREATE VIEW v AS {ENDLESS}",
        f"DROP TABLE curves; CREATE VIEW curves AS {ENDLESS}",
        "CREATE TRIGGER t AFTER INSERT ON events BEGIN DELETE FROM evaluations; END",
        "CREATE VIRTUAL TABLE v USING fts5(x)",
    ],
)
def test_a_ledger_with_a_program_in_it_is_refused(path: Path, program: str) -> None:
    with closing(sqlite3.connect(path)) as db:
        db.executescript(program)
    for use in (
        lambda: Ledger(path),
        lambda: Ledger(path, read_only=True),
        lambda: LedgerExchanges(path),
        lambda: open_or_recover(path),
    ):
        with pytest.raises(LedgerError, match="which no RoboMoRe wrote"):
            use()


@pytest.mark.parametrize(
    "change",
    [
        "CREATE TABLE more (x)",
        "CREATE INDEX i ON events (kind)",
        "DROP TABLE curves",
        "ALTER TABLE events ADD COLUMN x BLOB AS (zeroblob(1000000000))",
        "ALTER TABLE events RENAME COLUMN kind TO sort",
    ],
)
def test_a_ledger_with_other_tables_is_damaged_and_what_is_whole_is_kept(
    path: Path, change: str
) -> None:
    with closing(sqlite3.connect(path)) as db:
        db.executescript(change)
    with pytest.raises(LedgerDamaged, match="not those of a ledger"):
        Ledger(path, read_only=True)
    with closing(open_or_recover(path)) as ledger:
        assert ledger.evaluations() == [GOOD]


UNREADABLE = {
    "evaluations": ("k9", b'{"key": "k9"}'),
    "curves": ("k9", b"no curve"),
    "places": ('{"stage": 1}', "k1", 9),
    "proposals": ("{}", "given", b"{}"),
    "exchanges": ("k9", b"[]"),
    "events": (9, "cut", b'{"place": null}'),
}
"""A row that is whole, and that nobody can read."""


@pytest.mark.parametrize("table", TABLES)
def test_a_row_that_nobody_can_read_costs_only_itself(path: Path, table: str) -> None:
    row = (*UNREADABLE[table], 0.0)
    with closing(sqlite3.connect(path)) as db, db:
        places = ", ".join("?" * (len(row) + 1))
        db.execute(f"INSERT INTO {table} VALUES ({places})", (*row, digest(row)))
    with pytest.raises(LedgerDamaged, match="same command"):
        Ledger(path, read_only=True)
    with closing(open_or_recover(path)) as ledger:
        assert ledger.placed() == [(Place(stage="coarse"), GOOD)]


@pytest.mark.parametrize("name", ["..", "../x", "/etc", "a/b", "", ".", "a\x1b"])
def test_keys_and_artifacts_are_names_and_lead_nowhere(path: Path, name: str) -> None:
    with closing(Ledger(path)) as ledger:
        body = ledger._execute("SELECT body FROM evaluations")[0][0]  # as a forger would
        row = (GOOD.key, body.replace(b'"artifact":""', b'"artifact":"%s"' % name.encode()), 0.0)
        ledger.restore("evaluations", (*row, digest(row)))
    if name:
        with pytest.raises(LedgerDamaged, match=r"plain name|control character|\w"):
            Ledger(path, read_only=True)
    with closing(open_or_recover(path)) as ledger:
        assert all(not e.artifact for e in ledger.evaluations())


@pytest.mark.parametrize(
    "changes",
    [
        {"volume": -5.0},
        {"volume": 0.0},
        {"volume": 1e-300},
        {"fitness": 1e308},
        {"body": {"mass": -0.0}},
        {"behaviour": {"energy_j": 5e-324}},
        {"behaviour": {"forward_speed_m_s": -1e308}},
        {"efficiency": None},
        {"status": Status.CRASHED},
    ],
)
def test_an_evaluation_with_numbers_that_cannot_be_is_done_again(
    path: Path, changes: dict[str, Any]
) -> None:
    with closing(Ledger(path)) as ledger:
        ledger.add_evaluation(replace(GOOD, **changes))
    with pytest.raises(LedgerDamaged, match="same command"):
        Ledger(path, read_only=True)
    with closing(open_or_recover(path)) as ledger:
        assert ledger.evaluation(GOOD.key) is None


def test_text_that_cannot_be_encoded_is_replaced_and_never_stops_a_run(path: Path) -> None:
    """JSON and Python hold lone surrogates; no file does."""
    lone = "a\ud800b"
    with closing(Ledger(path)) as ledger, closing(LedgerExchanges(path)) as exchanges:
        slot = Slot("coarse", "reward", (0,))
        ledger.add_proposal(Proposal(slot, reward=Reward(lone, lone)), "a")
        ledger.add_proposal(Proposal(Slot("coarse", "morphology", (0,)), failure=lone), "b")
        ledger.add_proposal(
            Proposal(Slot("coarse", "morphology", (1,)), Morphology((0.1,), lone)), "c"
        )
        ledger.add_evaluation(Evaluation("k7", JOB, Status.FAILED, lone, notes=(lone,)))
        ledger.add_event("said", **{lone: lone})
        exchanges.add(
            Exchange(
                key="k8",
                slot=slot,
                repair=0,
                model="m",
                messages=(Message("user", lone),),
                sampling=Sampling(),
                reply=lone,
            )
        )
        exchanges.set_errors("k8", [lone])
        assert ledger.proposal(slot, "a") is not None
    with closing(Ledger(path)) as ledger, closing(LedgerExchanges(path)) as exchanges:
        assert [p.failure for p in ledger.proposals()] == ["", "a\ufffdb", ""]
        assert ledger.evaluations()[-1].diagnosis == "a\ufffdb"
        assert exchanges.all()[0].reply == "a\ufffdb"


@pytest.mark.parametrize("body", [None, b"[" * 100_000], ids=["no value", "nested without end"])
def test_a_body_that_is_none_or_without_end_is_damaged(path: Path, body: bytes | None) -> None:
    columns = ("k9", body, 0.0)
    with closing(sqlite3.connect(path)) as db, db:
        db.execute("INSERT INTO exchanges VALUES (?, ?, ?, ?)", (*columns, digest(columns)))
    with pytest.raises(LedgerDamaged):
        Ledger(path, read_only=True)
    with closing(LedgerExchanges(path, read_only=True)) as exchanges, pytest.raises(LedgerDamaged):
        exchanges.all()


def test_a_ledger_of_millions_of_numbers_is_refused(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with closing(Ledger(path)) as ledger:
        ledger.add_event("x", numbers=[1] * 2000)
    monkeypatch.setattr(rows, "MOST_NUMBERS", 3000)
    with closing(Ledger(path, read_only=True)) as ledger:
        assert len(ledger.events()) == 1
        with pytest.raises(LedgerError, match="more than 3,000 values, which no run writes"):
            ledger.events()


def test_a_ledger_of_long_texts_is_refused(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with closing(Ledger(path)) as ledger:
        ledger.add_event("x", text="x" * 5000)
        monkeypatch.setattr(rows, "MOST_BYTES", 4000)
        with pytest.raises(LedgerError, match="more than 4,000 bytes, which no run writes"):
            ledger.events()


def test_a_row_of_many_megabytes_is_damage(path: Path) -> None:
    with closing(sqlite3.connect(path)) as db, db:
        db.execute("INSERT INTO events VALUES (1, 'x', zeroblob(70000000), 0.0, x'00')")
    with pytest.raises(LedgerDamaged, match="too big"):
        Ledger(path, read_only=True)


def test_one_evaluation_in_many_places_is_read_once(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with closing(Ledger(path)) as ledger:
        for index in range(50):
            ledger.add_place(Place(stage="fine", index=(index,)), GOOD.key)
        monkeypatch.setattr(rows, "MOST_NUMBERS", 1500)
        assert len(ledger.placed()) == 51


def test_an_evaluation_of_very_many_numbers_is_refused() -> None:
    many = {f"measure {number}": 1.0 for number in range(2_000)}
    with pytest.raises(ValueError, match=r"2,0\d\d named numbers \(the most is 2,000\)"):
        check_numbers(replace(GOOD, behaviour=many, body={"mass": 1.0}))
