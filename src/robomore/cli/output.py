"""Where output goes: results to stdout, everything else to stderr.

Nothing else in the command line writes to a terminal. Much of what is shown was written by a model,
by untrusted code or by whoever made a run folder, so every character that steers a terminal is
replaced here.
"""

from __future__ import annotations

import json
import re
import sys
from typing import TYPE_CHECKING, Any

from robomore.text import sanitize

if TYPE_CHECKING:
    from rich.console import Console


def write(text: str) -> None:
    """Write a result to stdout."""
    _write(sys.stdout, sanitize(text))


def tell(text: str) -> None:
    """Write what is no result to stderr, at once."""
    _write(sys.stderr, sanitize(text))
    sys.stderr.flush()


def write_json(data: Any) -> None:
    """Write `data` to stdout as indented JSON, numbers to the last digit, text to the last letter.

    What a terminal must not see is escaped, so that a program reads it and a terminal does not.
    """
    text = json.dumps(data, indent=2, ensure_ascii=False)
    _write(sys.stdout, _NOT_PLAIN.sub(_escaped, text) + "\n")


def beginning(text: str, whole: str) -> str:
    """Return the beginning of a text that somebody else wrote, and what it lacks.

    Args:
        text: of any length.
        whole: what prints or holds all of it.
    """
    lines = text[:_MOST_CHARACTERS].split("\n")[:_MOST_LINES]
    shown = "\n".join(lines)
    if shown == text:
        return text
    left = len(text) - len(shown)
    return f"{shown}\n… {left:,} more characters of {len(text):,}; {whole} has all of it"


def console(stderr: bool = False) -> Console:
    """Return a console; without a terminal it writes plain text, not cut to any width."""
    from robomore.cli.clean_console import CleanConsole

    stream = sys.stderr if stderr else sys.stdout
    width = None if stream.isatty() else 160
    return CleanConsole(
        stderr=stderr,
        highlight=False,
        soft_wrap=not stream.isatty(),
        width=width,
        # What a designer wrote in brackets or between colons is text.
        markup=False,
        emoji=False,
    )


_MOST_LINES, _MOST_CHARACTERS = 200, 20_000
"""Of a text that is shown in part."""

_NOT_PLAIN = re.compile(r"[^\n -~]")


def _escaped(found: re.Match[str]) -> str:
    character = found[0]
    return character if character.isprintable() else json.dumps(character)[1:-1]


def _write(stream: Any, text: str) -> None:
    # A terminal may not know every letter.
    encoding = stream.encoding or "utf-8"
    stream.write(text.encode(encoding, "replace").decode(encoding))
