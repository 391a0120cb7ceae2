"""Characters that have no place in a reward or in the name of a term."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator

from robomore.rewards.finding import Finding

_DIRECTIONS = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
"""They change the order in which text is shown, so that a program can look like another one."""

_SEPARATORS = frozenset("\u0085\u2028\u2029\ufeff")


def check_characters(source: str) -> Iterator[Finding]:
    """Find characters that steer a terminal, or how text is shown; at most one in each line."""
    for number, line in enumerate(source.removeprefix("\ufeff").split("\n"), start=1):
        for character in line.removesuffix("\r"):
            control = unicodedata.category(character) == "Cc" and character != "\t"
            if control or character in _DIRECTIONS or character in _SEPARATORS:
                yield Finding(
                    number,
                    "error",
                    f"the character U+{ord(character):04X} steers how text is shown; remove it, or "
                    "write it as an escape",
                )
                break
