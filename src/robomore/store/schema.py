"""What a ledger's file holds: its tables, and which rows this RoboMoRe can read.

A ledger may come from somebody else. A view or a trigger in it would be a program that runs as the
ledger is read, so a file with more than our own tables is refused. A row whose digest is right may
still hold what nobody can read; it counts as damaged, so that it never stops a run for good.
"""

from __future__ import annotations

import sqlite3
import zlib
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import msgspec

from robomore.events import Cut
from robomore.llm.exchange import Exchange
from robomore.types import Curve, Evaluation, Morphology, Place, Reward, Slot

SCHEMA = 3
"""Raised when the tables change."""

CREATE = """
CREATE TABLE evaluations (key TEXT PRIMARY KEY, body BLOB, time REAL, digest BLOB) STRICT;
CREATE TABLE curves (key TEXT PRIMARY KEY, body BLOB, time REAL, digest BLOB) STRICT;
CREATE TABLE places
  (place TEXT PRIMARY KEY, evaluation TEXT, seq INTEGER, time REAL, digest BLOB) STRICT;
CREATE TABLE proposals
  (slot TEXT PRIMARY KEY, given TEXT, body BLOB, time REAL, digest BLOB) STRICT;
CREATE TABLE exchanges (key TEXT PRIMARY KEY, body BLOB, time REAL, digest BLOB) STRICT;
CREATE TABLE events (seq INTEGER PRIMARY KEY, kind TEXT, body BLOB, time REAL, digest BLOB) STRICT;
"""
TABLES = ("evaluations", "curves", "places", "proposals", "exchanges", "events")

_LARGEST = 1e12
"""Far from every number of a robot, and from where sums and products stop being finite."""
_MOST_NAMES = 2_000
"""Facts, measures of behaviour and reward terms of one evaluation; usual ones have some twenty."""
_MOST_PLACES = 10**6
"""Along each axis of a stage, and of repeats."""
_LONGEST_CURVE = 2**20
"""Bytes of a curve when it is unpacked."""


@dataclass(frozen=True, slots=True)
class Proposal:
    """What a designer answered in one slot: a morphology, a reward, or why there is none."""

    slot: Slot
    morphology: Morphology | None = None
    reward: Reward | None = None
    failure: str = ""


def foreign_objects(db: sqlite3.Connection) -> list[str]:
    """Return what a file holds besides tables and their indices, such as `trigger x`."""
    found = db.execute("SELECT type, name, rootpage FROM sqlite_schema ORDER BY rowid")
    return [
        f"{'virtual table' if kind == 'table' else kind} {name}"
        for kind, name, page in found
        if kind not in ("table", "index") or not page
    ]


def has_our_tables(db: sqlite3.Connection) -> bool:
    """Return whether a file's tables are those that we make, to the last word."""
    return _objects(db) == _ours()


def is_readable(db: sqlite3.Connection, table: str) -> bool:
    """Return whether reading a table reads what was stored, and computes nothing."""
    query = "SELECT type, rootpage > 0 FROM sqlite_schema WHERE name = ?"
    columns = db.execute("SELECT hidden FROM pragma_table_xinfo(?)", (table,)).fetchall()
    return db.execute(query, (table,)).fetchall() == [("table", 1)] and set(columns) == {(0,)}


def check_row(table: str, row: tuple[Any, ...]) -> None:
    """Refuse a row that cannot be read.

    Args:
        table: where it stands.
        row: its columns, with or without time and digest.

    Raises:
        ValueError: saying why.
    """
    if None in row:
        raise ValueError(f"a row of {table} has a column without a value")
    try:
        _CHECKS[table](*row[: _COLUMNS[table]])
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError, TypeError) as error:
        raise ValueError(f"a row of {table} cannot be read: {error}") from None


def unpacked_curve(body: bytes) -> Curve:
    """Return a curve as it stands in the ledger.

    Raises:
        ValueError: it is none, or longer than any can be.
    """
    opener = zlib.decompressobj()
    try:
        text = opener.decompress(body, _LONGEST_CURVE)
    except zlib.error as error:
        raise ValueError(str(error)) from None
    if opener.unconsumed_tail:
        raise ValueError("a curve is longer than any can be")
    return msgspec.json.decode(text, type=Curve)


def check_numbers(evaluation: Evaluation) -> None:
    """Refuse an evaluation whose numbers do not fit its status, or are no robot's.

    Raises:
        ValueError: saying why.
    """
    numbers = evaluation.fitness, evaluation.volume, evaluation.efficiency
    given = [number for number in numbers if number is not None]
    if not evaluation.ok:
        if given:
            raise ValueError(f"it says {evaluation.status} and has numbers all the same")
        return
    named = len(evaluation.behaviour) + len(evaluation.body) + len(evaluation.terms)
    if named > _MOST_NAMES:
        raise ValueError(f"it has {named:,} named numbers (the most is {_MOST_NAMES:,})")
    if len(given) < len(numbers) or evaluation.volume is None:
        raise ValueError("it says ok without fitness, volume and efficiency")
    for name, divisor in (
        ("volume", evaluation.volume),
        ("mass", evaluation.body.get("mass", 1.0)),
        ("energy", evaluation.energy or 1.0),
    ):
        if not 1 / _LARGEST <= divisor <= _LARGEST:
            raise ValueError(f"its {name} is {divisor:g}, which no robot has")
    given += [*evaluation.episode_fitness, *evaluation.body.values()]
    given += [*evaluation.behaviour.values(), evaluation.seconds]
    if any(abs(number) > _LARGEST for number in given):
        raise ValueError(f"it has a number beyond {_LARGEST:g}, which none can be")


def _evaluation(key: str, body: bytes) -> None:
    found = msgspec.json.decode(body, type=Evaluation)
    if found.key != key:
        raise ValueError(f"the evaluation {key!r} says that it is another one")
    check_numbers(found)


def _curve(key: str, body: bytes) -> None:
    unpacked_curve(body)


def _place(place: str, evaluation: str, seq: int) -> None:
    _check_place(msgspec.json.decode(place, type=Place))


def _check_place(place: Place) -> None:
    if not all(0 <= number < _MOST_PLACES for number in (*place.index, place.repeat)):
        raise ValueError(f"a place in the stage {place.stage[:50]!r} has a number that none has")


def _check_slot(slot: Slot) -> None:
    if not slot.index or not all(0 <= n < _MOST_PLACES for n in (*slot.index, slot.attempt)):
        raise ValueError(f"a slot of the stage {slot.stage[:50]!r} has a number that none has")


def _proposal(slot: str, given: str, body: bytes) -> None:
    _check_slot(msgspec.json.decode(slot, type=Slot))
    _check_slot(msgspec.json.decode(body, type=Proposal).slot)


def _exchange(key: str, body: bytes) -> None:
    msgspec.json.decode(body, type=Exchange)


def _event(seq: int, kind: str, body: bytes) -> None:
    facts = msgspec.json.decode(body, type=dict[str, Any])
    if kind == "hint":
        found = msgspec.json.decode(body, type=dict[str, str])
        if set(found) != {"slot", "hint"}:
            raise ValueError("a hint without slot or text")
    if kind == "cut":
        _check_place(msgspec.convert(facts, Cut).place)


_CHECKS: dict[str, Callable[..., None]] = {
    "evaluations": _evaluation,
    "curves": _curve,
    "places": _place,
    "proposals": _proposal,
    "exchanges": _exchange,
    "events": _event,
}
_COLUMNS = {"evaluations": 2, "curves": 2, "places": 3, "proposals": 3, "exchanges": 2, "events": 3}


def _objects(db: sqlite3.Connection) -> set[tuple[Any, ...]]:
    found = db.execute("SELECT type, name, tbl_name, sql FROM sqlite_schema")
    return {(kind, name, table, " ".join((sql or "").split())) for kind, name, table, sql in found}


def _ours() -> set[tuple[Any, ...]]:
    with closing(sqlite3.connect(":memory:")) as db:
        db.executescript(CREATE)
        return _objects(db)
