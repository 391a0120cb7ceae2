"""One thing that is said about a reward."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong, or probably wrong, or good to know.

    Attributes:
        line: of the text, counted from 1.
        severity: an `error` keeps the reward from being trained; a `warning` does not, but a
            designer is asked once to reconsider; a `note` changes nothing.
        message: what is wrong and what to do instead.
    """

    line: int
    severity: Literal["error", "warning", "note"]
    message: str
