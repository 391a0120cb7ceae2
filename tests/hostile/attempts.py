"""The strangers' programs in `rewards/`, each with what is to come of it in its first lines."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parent / "rewards"


@dataclass(frozen=True)
class Attempt:
    """One program.

    Attributes:
        name: folder and file.
        words: what it tries.
        source: its text, with aims such as `@SECRET@` to be filled in.
        expected: how its evaluation may end.
        check: the gravest that the check may find in it: `error`, `warning` or `clean`.
    """

    name: str
    words: str
    source: str
    expected: tuple[str, ...]
    check: tuple[str, ...]


def attempts() -> list[Attempt]:
    """Return all of them, in the order of their names."""
    return [_read(path) for path in sorted(FOLDER.glob("*/*.py"))]


def _read(path: Path) -> Attempt:
    source = path.read_text()
    header = dict(line[2:].split(": ", 1) for line in source.splitlines()[:3])
    return Attempt(
        name=f"{path.parent.name}/{path.stem}",
        words=header["attempt"],
        source=source,
        expected=tuple(header["expect"].split(" or ")),
        check=tuple(header["check"].split(" or ")),
    )
