"""A person's remarks for the designer: with the command, or written down while a run goes on."""

from __future__ import annotations

import logging

from robomore.plain_files import NotPlainError
from robomore.store.ledger import Ledger
from robomore.store.rundir import RunFolder
from robomore.text import encodable, to_json
from robomore.types import Slot

MOST_CHARACTERS = 4000
"""Of a remark; what comes after is left out, with a warning."""

log = logging.getLogger(__name__)


def no_hint(slot: Slot) -> str:
    """Return no remark."""
    return ""


class Hints:
    """Knows which remark belongs to a slot, and writes it down before the designer is asked.

    A slot that was asked for before keeps its remark, so that a resumed run sends the same prompts.
    Any other one gets the text of the command and what `hint.txt` in the run's folder holds now.
    """

    def __init__(self, text: str, folder: RunFolder, ledger: Ledger) -> None:
        self._text = text
        self._folder = folder
        self._ledger = ledger
        self._known = ledger.hints()

    def of(self, slot: Slot) -> str:
        """Return the remark for a slot, empty for none."""
        name = to_json(slot).decode()
        if name not in self._known:
            parts = (self._text, self._written())
            hint = encodable("\n\n".join(part.strip() for part in parts if part.strip()))
            if len(hint) > MOST_CHARACTERS:
                log.warning("only the first %d characters of the hint are used", MOST_CHARACTERS)
                hint = hint[:MOST_CHARACTERS]
            if hint:
                self._ledger.add_hint(slot, hint)
            self._known[name] = hint
        return self._known[name]

    def _written(self) -> str:
        name = self._folder.hint.name
        try:
            if not self._folder.files.is_file(name):
                return ""
            return self._folder.files.read(name, 16 * MOST_CHARACTERS).decode("utf-8-sig")
        except (OSError, NotPlainError, ValueError) as error:
            log.warning("%s is not used: %s", self._folder.hint, error)
            return ""
