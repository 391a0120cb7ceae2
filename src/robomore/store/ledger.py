"""The ledger: everything that a run has done, in one SQLite file, written as it happens."""

from __future__ import annotations

import zlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import msgspec

from robomore.errors import RoboMoReError
from robomore.events import Cut, Observer
from robomore.events import Event as Happening
from robomore.store.rows import Rows
from robomore.types import Curve, Evaluation, Morphology, Place, Reward, Slot

SCHEMA = 3
"""Raised when the tables change."""

_TABLES = """
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


_LONGEST_CURVE = 2**20
"""Bytes of a curve when it is unpacked."""


@dataclass(frozen=True, slots=True)
class Proposal:
    """What a designer answered in one slot: a morphology, a reward, or why there is none."""

    slot: Slot
    morphology: Morphology | None = None
    reward: Reward | None = None
    failure: str = ""


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened in a run, for people who look back."""

    kind: str
    body: dict[str, Any]
    time: float


class Ledger(Rows):
    """Append-only memory of one run. Rows carry a digest, so damage is found and never believed.

    One process writes; others may read meanwhile.
    """

    def __init__(self, path: Path, read_only: bool = False) -> None:
        """Open the ledger at `path`, or make one.

        Raises:
            LedgerError: a row of it is damaged, or it is of another version.
            StorageFailed: the disk is full, or cannot be written.
        """
        super().__init__(path, SCHEMA, read_only, durable=False)
        try:
            if self._version == 0:
                self._script(f"BEGIN; {_TABLES} PRAGMA user_version={SCHEMA}; COMMIT;")
            for table in TABLES:
                for _ in self._select(f"SELECT * FROM {table}"):
                    pass
        except RoboMoReError:
            self.close()
            raise

    # Evaluations ---------------------------------------------------------------------------------

    def evaluation(self, key: str) -> Evaluation | None:
        """Return the evaluation of that key without its curve, if it was done."""
        for _, body, _ in self._select("SELECT * FROM evaluations WHERE key = ?", (key,)):
            return self._decode(body, Evaluation)
        return None

    def add_evaluation(self, evaluation: Evaluation) -> None:
        """Keep an evaluation; its curve goes into a table of its own, compressed."""
        if evaluation.curve is not None:
            body = zlib.compress(msgspec.json.encode(evaluation.curve), 9)
            self._insert("curves", evaluation.key, body)
        bare = replace(evaluation, curve=None)
        self._insert("evaluations", evaluation.key, msgspec.json.encode(bare))

    def curve(self, key: str) -> Curve | None:
        """Return the training curve of the evaluation of that key, if it has one."""
        for _, body, _ in self._select("SELECT * FROM curves WHERE key = ?", (key,)):
            opener = zlib.decompressobj()
            try:
                text = opener.decompress(body, _LONGEST_CURVE)
            except zlib.error as error:
                raise self.damaged(error) from None
            if opener.unconsumed_tail:
                raise self.damaged("a curve is longer than any can be")
            return self._decode(text, Curve)
        return None

    def add_place(self, place: Place, key: str) -> None:
        """Note that the search asked for an evaluation in this place."""
        name = msgspec.json.encode(place).decode()
        with self._lock:
            known = list(self._select("SELECT * FROM places WHERE place = ?", (name,)))
            if known and known[0][1] == key:
                return
            (last,) = self._execute("SELECT coalesce(max(seq), 0) FROM places")[0]
            self._insert("places", name, key, known[0][2] if known else last + 1)

    def placed(self) -> list[tuple[Place, Evaluation]]:
        """Return every evaluation in each place it was asked for, in the order of asking."""
        found = []
        for place, key, *_ in self._select("SELECT * FROM places ORDER BY seq"):
            evaluation = self.evaluation(key)
            if evaluation is not None:
                found.append((self._decode(place, Place), evaluation))
        return found

    def evaluations(self) -> list[Evaluation]:
        """Return all evaluations without their curves, oldest first."""
        rows = self._select("SELECT * FROM evaluations ORDER BY rowid")
        return [self._decode(body, Evaluation) for _, body, _ in rows]

    # Proposals -----------------------------------------------------------------------------------

    def proposal(self, slot: Slot, given: str) -> Proposal | None:
        """Return what was proposed in `slot` from the same input (`given` is its content key)."""
        query = "SELECT * FROM proposals WHERE slot = ? AND given = ?"
        for _, _, body, _ in self._select(query, (msgspec.json.encode(slot).decode(), given)):
            return self._decode(body, Proposal)
        return None

    def add_proposal(self, proposal: Proposal, given: str) -> None:
        slot = msgspec.json.encode(proposal.slot).decode()
        self._insert("proposals", slot, given, msgspec.json.encode(proposal))

    def proposals(self) -> list[Proposal]:
        """Return all proposals, oldest first."""
        rows = self._select("SELECT * FROM proposals ORDER BY rowid")
        return [self._decode(body, Proposal) for _, _, body, _ in rows]

    # Events --------------------------------------------------------------------------------------

    def add_event(self, kind: str, **body: Any) -> None:
        self._append("events", kind, msgspec.json.encode(body))

    def noting(self, observe: Observer) -> Observer:
        """Return an observer that passes everything on, and writes down once who was cut."""
        known = {msgspec.json.encode(event.body) for event in self.events() if event.kind == "cut"}

        def note(event: Happening) -> None:
            if isinstance(event, Cut):
                body = msgspec.to_builtins(event)
                if msgspec.json.encode(body) not in known:
                    self.add_event("cut", **body)
            observe(event)

        return note

    def cuts(self) -> list[Cut]:
        """Return whom screening cut, in the order of the rungs."""
        found = [msgspec.convert(e.body, Cut) for e in self.events() if e.kind == "cut"]
        return sorted(found, key=lambda cut: cut.steps)

    def events(self) -> list[Event]:
        rows = self._select("SELECT * FROM events ORDER BY seq")
        return [Event(kind, self._decode(body, dict[str, Any]), at) for _, kind, body, at in rows]
