"""The ledger: everything that a run has done, in one SQLite file, written as it happens."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from robomore.events import Cut, Observer
from robomore.events import Event as Happening
from robomore.store.rows import Rows, digest
from robomore.types import Evaluation, Morphology, Place, Reward, Slot

SCHEMA = 1
"""Raised when the tables change."""

_TABLES = """
CREATE TABLE evaluations (key TEXT PRIMARY KEY, body BLOB, digest BLOB, time REAL) STRICT;
CREATE TABLE places (place TEXT PRIMARY KEY, evaluation TEXT, seq INTEGER) STRICT;
CREATE TABLE proposals
  (slot TEXT PRIMARY KEY, given TEXT, body BLOB, digest BLOB, time REAL) STRICT;
CREATE TABLE exchanges (key TEXT PRIMARY KEY, body BLOB, digest BLOB, time REAL) STRICT;
CREATE TABLE events (seq INTEGER PRIMARY KEY, kind TEXT, body BLOB, time REAL) STRICT;
"""


@dataclass(frozen=True, slots=True)
class Proposal:
    """What a designer answered in one slot: a body, a reward, or why there is none."""

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
            LedgerError: damaged, or of a newer version.
        """
        super().__init__(path, SCHEMA, read_only, durable=False)
        if self._version == 0 and not read_only:
            self._script(f"BEGIN; {_TABLES} PRAGMA user_version={SCHEMA}; COMMIT;")

    # Evaluations ---------------------------------------------------------------------------------

    def evaluation(self, key: str) -> Evaluation | None:
        """Return the evaluation of that key, if it was done."""
        return self._read("SELECT body, digest FROM evaluations WHERE key = ?", key, Evaluation)

    def add_evaluation(self, evaluation: Evaluation) -> None:
        self._write(
            "INSERT OR REPLACE INTO evaluations VALUES (?, ?, ?, ?)", evaluation.key, evaluation
        )

    def add_place(self, place: Place, key: str) -> None:
        """Note that the search asked for an evaluation in this place."""
        self._execute(
            "INSERT INTO places VALUES (?, ?, (SELECT coalesce(max(seq), 0) + 1 FROM places)) "
            "ON CONFLICT (place) DO UPDATE SET evaluation = excluded.evaluation",
            (msgspec.json.encode(place).decode(), key),
        )

    def placed(self) -> list[tuple[Place, Evaluation]]:
        """Return every evaluation in each place it was asked for, in the order of asking."""
        rows = self._execute("SELECT place, evaluation FROM places ORDER BY seq")
        found = []
        for place, key in rows:
            evaluation = self.evaluation(key)
            if evaluation is not None:
                found.append((self._decode(place.encode(), Place), evaluation))
        return found

    def evaluations(self) -> list[Evaluation]:
        """Return all evaluations, oldest first."""
        query = "SELECT body, digest FROM evaluations ORDER BY rowid"
        return list(self._all(query, Evaluation))

    # Proposals -----------------------------------------------------------------------------------

    def proposal(self, slot: Slot, given: str) -> Proposal | None:
        """Return what was proposed in `slot` from the same input (`given` is its content key)."""
        query = "SELECT body, digest FROM proposals WHERE slot = ? AND given = ?"
        return self._read(query, (msgspec.json.encode(slot).decode(), given), Proposal)

    def add_proposal(self, proposal: Proposal, given: str) -> None:
        body = msgspec.json.encode(proposal)
        slot = msgspec.json.encode(proposal.slot).decode()
        self._execute(
            "INSERT OR REPLACE INTO proposals VALUES (?, ?, ?, ?, ?)",
            (slot, given, body, digest(body), time.time()),
        )

    def proposals(self) -> list[Proposal]:
        """Return all proposals, oldest first."""
        return list(self._all("SELECT body, digest FROM proposals ORDER BY rowid", Proposal))

    # Events --------------------------------------------------------------------------------------

    def add_event(self, kind: str, **body: Any) -> None:
        self._execute(
            "INSERT INTO events (kind, body, time) VALUES (?, ?, ?)",
            (kind, msgspec.json.encode(body), time.time()),
        )

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
        rows = self._execute("SELECT kind, body, time FROM events ORDER BY seq")
        return [Event(kind, self._decode(body, dict[str, Any]), at) for kind, body, at in rows]
