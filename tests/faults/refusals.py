"""What a command told, and what it has to tell where it refuses."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Said:
    """How a command ended and what it told."""

    status: int
    out: str
    err: str


Command = Callable[..., Said]


def refused(said: Said, done: str, status: int = 2) -> None:
    """A refusal is one line that says what to do."""
    assert said.status == status, f"{said} after {done}"
    assert said.out == "", done
    assert said.err.startswith("robomore: ") and said.err.count("\n") == 1, f"{said} after {done}"
    assert "Traceback" not in said.err
    assert any(word in said.err for word in ("same command", "--out", "restore")), said.err


def facts(shown: str) -> dict[str, Any]:
    """Return what `show --json` tells, but where the folder is."""
    data: dict[str, Any] = json.loads(shown)
    data.pop("run")
    return data


def measured(shown: str) -> dict[str, Any]:
    """Return what `show --json` tells of results, without what they cost."""
    data = facts(shown)
    data.pop("cost")
    return data
