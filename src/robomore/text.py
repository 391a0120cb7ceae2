"""Makes text that somebody else wrote fit to be shown and to be kept."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape
from typing import Any

import msgspec

_REPLACEMENT = "\N{REPLACEMENT CHARACTER}"
_SURROGATE = re.compile("[\ud800-\udfff]")
_MARKUP = re.compile(r"([\\`*_\[\]|~])")


def sanitize(text: str) -> str:
    """Return `text` with every character replaced that steers a terminal or cannot be encoded.

    Control and bidirectional characters are replaced; line feeds and tabs are kept. Any other space
    becomes a plain one.
    """
    if text.replace("\n", "").replace("\t", "").isprintable():
        return text
    return "".join(c if c.isprintable() or c in "\n\t" else _plain(c) for c in text)


def odd_characters(text: str) -> list[str]:
    """Return the characters that `sanitize` replaces by a mark, each once, in order."""
    return [c for c in dict.fromkeys(text) if c != _REPLACEMENT and sanitize(c) == _REPLACEMENT]


def one_line(text: str) -> str:
    """Return what `sanitize` does, with all white space in a row as one space."""
    return " ".join(sanitize(text).split())


def text_only(text: str) -> str:
    """Return text of somebody else's as one line of Markdown that is text and nothing else."""
    return _MARKUP.sub(r"\\\1", escape(one_line(text), quote=False))


def shortened(text: str, most: int = 100) -> str:
    """Return `text` cut to `most` characters, for where a picture has room for no more."""
    return text if len(text) <= most else f"{text[: most - 1]}\N{HORIZONTAL ELLIPSIS}"


def listed(names: Sequence[str], most: int = 3) -> str:
    """Return the first `most` names with commas, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(names[:most])}{more}"


def encodable(text: str) -> str:
    """Return `text` with lone surrogates replaced, which no file and no message can hold."""
    return text if text.isascii() else _SURROGATE.sub(_REPLACEMENT, text)


def to_json(value: Any, *, sort_keys: bool = False) -> bytes:
    """Return `value` as JSON; text that cannot be encoded is replaced, never an error.

    Args:
        value: what msgspec encodes.
        sort_keys: gives equal values equal bytes.
    """
    order = "deterministic" if sort_keys else None
    try:
        return msgspec.json.encode(value, order=order)  # type: ignore[arg-type]
    except UnicodeEncodeError:
        return msgspec.json.encode(_encodable(msgspec.to_builtins(value)), order=order)  # type: ignore[arg-type]


def _plain(character: str) -> str:
    return " " if character.isspace() and character not in _CONTROLS else _REPLACEMENT


_CONTROLS = "\r\v\f\x1c\x1d\x1e\x1f\x85\u2028\u2029"
"""They count as white space, and move a cursor or begin a line."""


def _encodable(value: Any) -> Any:
    match value:
        case str():
            return encodable(value)
        case dict():
            return {_encodable(key): _encodable(item) for key, item in value.items()}
        case list() | tuple():
            return [_encodable(item) for item in value]
    return value
