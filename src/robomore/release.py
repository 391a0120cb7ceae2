"""Which RoboMoRe this is."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

VERSION = "0.3.0.dev0"

_DECIDE_NUMBERS = ("designers", "envs", "evaluation", "rewards", "search", "tasks", "training")
"""The packages whose code decides what is tried, and what comes of it."""


@cache
def development_source() -> str | None:
    """Return a digest of the code that decides numbers, or `None` for a version that was released.

    The code of a released version is known by its number. Between two releases many states of the
    code have one number.
    """
    return _source(Path(__file__).parent) if ".dev" in VERSION else None


def _source(package: Path) -> str:
    found = hashlib.sha256()
    for part in _DECIDE_NUMBERS:
        for path in sorted((package / part).rglob("*.py")):
            found.update(f"{path.relative_to(package).as_posix()}\0".encode())
            found.update(path.read_bytes())
            found.update(b"\0")
    return found.hexdigest()[:12]
