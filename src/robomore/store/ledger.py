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
from robomore.store.schema import TABLES, Proposal, check_row, unpacked_curve
from robomore.text import to_json
from robomore.types import Curve, Evaluation, Place, Slot


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
            LedgerError: a row of it is damaged, or it is of another version, or somebody else's.
            StorageFailed: the disk is full, or cannot be written.
        """
        super().__init__(path, read_only, durable=False)
        # One process writes, so it need not look for the last one each time.
        self._last_place: int | None = None
        try:
            for table in TABLES:
                for row in self._select(f"SELECT * FROM {table}"):
                    try:
                        check_row(table, row)
                    except ValueError as error:
                        raise self.damaged(error) from None
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
            body = zlib.compress(to_json(evaluation.curve), 9)
            self._insert("curves", evaluation.key, body)
        bare = replace(evaluation, curve=None)
        self._insert("evaluations", evaluation.key, to_json(bare))

    def curve(self, key: str) -> Curve | None:
        """Return the training curve of the evaluation of that key, if it has one."""
        for _, body, _ in self._select("SELECT * FROM curves WHERE key = ?", (key,)):
            try:
                return unpacked_curve(body)
            except (ValueError, RecursionError) as error:
                raise self.damaged(error) from None
        return None

    def curves(self) -> dict[str, Curve]:
        """Return all training curves, by the keys of their evaluations."""
        found = {}
        for key, body, _ in self._select("SELECT * FROM curves"):
            try:
                found[key] = unpacked_curve(body)
            except (ValueError, RecursionError) as error:
                raise self.damaged(error) from None
        return found

    def add_place(self, place: Place, key: str) -> None:
        """Note that the search asked for an evaluation in this place."""
        name = to_json(place).decode()
        with self._lock:
            known = list(self._select("SELECT * FROM places WHERE place = ?", (name,)))
            if known and known[0][1] == key:
                return
            if self._last_place is None:
                ((self._last_place,),) = self._execute("SELECT coalesce(max(seq), 0) FROM places")
            if not known:
                self._last_place += 1
            self._insert("places", name, key, known[0][2] if known else self._last_place)

    def placed(self) -> list[tuple[Place, Evaluation]]:
        """Return every evaluation in each place it was asked for, in the order of asking."""
        found: list[tuple[Place, Evaluation]] = []
        known: dict[str, Evaluation | None] = {}
        for place, key, *_ in self._select("SELECT * FROM places ORDER BY seq"):
            if key not in known:
                known[key] = self.evaluation(key)
            evaluation = known[key]
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
        for _, _, body, _ in self._select(query, (to_json(slot).decode(), given)):
            return self._decode(body, Proposal)
        return None

    def add_proposal(self, proposal: Proposal, given: str) -> None:
        slot = to_json(proposal.slot).decode()
        self._insert("proposals", slot, given, to_json(proposal))

    def proposals(self) -> list[Proposal]:
        """Return all proposals, oldest first."""
        rows = self._select("SELECT * FROM proposals ORDER BY rowid")
        return [self._decode(body, Proposal) for _, _, body, _ in rows]

    # Events --------------------------------------------------------------------------------------

    def add_event(self, kind: str, **body: Any) -> None:
        self._append("events", kind, to_json(body))

    def noting(self, observe: Observer) -> Observer:
        """Return an observer that passes everything on, and writes down once who was cut."""
        known = {to_json(event.body) for event in self.events() if event.kind == "cut"}

        def note(event: Happening) -> None:
            if isinstance(event, Cut):
                body = msgspec.to_builtins(event)
                if to_json(body) not in known:
                    self.add_event("cut", **body)
            observe(event)

        return note

    def cuts(self) -> list[Cut]:
        """Return whom screening cut, in the order of the rungs."""
        found = [msgspec.convert(e.body, Cut) for e in self.events() if e.kind == "cut"]
        return sorted(found, key=lambda cut: cut.steps)

    def add_hint(self, slot: Slot, hint: str) -> None:
        """Note the remark of a person that the designer is given for a slot."""
        self.add_event("hint", slot=to_json(slot).decode(), hint=hint)

    def hints(self) -> dict[str, str]:
        """Return the remark that each slot was asked for with, by the slot as JSON."""
        bodies = [event.body for event in self.events() if event.kind == "hint"]
        return {str(body["slot"]): str(body["hint"]) for body in bodies}

    def events(self) -> list[Event]:
        rows = self._select("SELECT * FROM events ORDER BY seq")
        return [Event(kind, self._decode(body, dict[str, Any]), at) for _, kind, body, at in rows]
