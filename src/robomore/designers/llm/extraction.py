"""Finds the JSON object in the answer of a language model.

It accepts fences, prose, comments, trailing commas and thoughts around it, as long as the answer
has only one possible meaning.
"""

from __future__ import annotations

import ast
import json
import re
from typing import Any

from robomore.designers.llm.thoughts import after_final_heading, without_thoughts
from robomore.designers.llm.wrappings import (
    closing_brace,
    straightened,
    unboxed,
    without_entities,
    without_quote,
)

LONGEST = 200_000
"""A longer answer is refused. No reasonable answer has so many characters."""
_TRIES = 40
"""Opening braces that are tried. Prose has a few, hostile text has thousands."""
_DEEPEST = 4
"""Objects around the wanted one that are looked into."""

_SPACES = str.maketrans({"\u00a0": " ", "\u2007": " ", "\u202f": " "})
"""Spaces that neither JSON nor Python takes."""
_INVISIBLE = re.compile("[\ufeff\u200b\u2060]")
"""A byte order mark, and spaces without width."""


EMPTY = "the answer is empty"
"""The message about an answer with nothing beside thoughts."""


class NotFound(Exception):
    """The answer does not hold what was asked for. The message says what is wrong."""


class Unreadable(NotFound):
    """There is nothing in the answer that can be read as JSON or as Python code."""


def find_object(text: str, wanted: str) -> dict[str, Any]:
    """Return the JSON object in `text` that has the key `wanted`.

    Raises:
        NotFound: there is no such object, it is invalid, or several differ.
    """
    given, text = text, cleared(text, wanted)
    found, errors = _objects(text, wanted)
    for other in _otherwise_written(given):
        if not found:
            text = cleared(other, wanted)
            found, errors = _objects(text, wanted)
    if len(found) > 1:
        final = after_final_heading(text)
        last = _objects(final, wanted)[0] if final is not None else []
        if len(last) != 1:
            raise NotFound(f"the answer holds {len(found)} different designs; answer with one")
        found = last
    if found:
        return found[0]
    error = errors[0] if errors else Unreadable(f'the answer holds no JSON object with "{wanted}"')
    if isinstance(error, Unreadable) and straightened(given) != given:
        raise Unreadable(f'{error}; mind that JSON takes straight quotes (") and no others')
    raise error


def object_in(text: str, wanted: str) -> dict[str, Any] | None:
    """Return what `find_object` finds, `None` if it finds nothing."""
    try:
        return find_object(text, wanted)
    except NotFound:
        return None


def _otherwise_written(text: str) -> list[str]:
    """Return `text` without HTML's names of characters, and with straight quotes besides."""
    plain = without_entities(text)
    ways = dict.fromkeys((plain, straightened(plain)))
    return [way for way in ways if way != text]


def cleared(text: str, wanted: str) -> str:
    """Return `text` without thoughts, wrappings and invisible characters.

    Raises:
        NotFound: it is empty or too long.
    """
    if len(text) > LONGEST:
        raise Unreadable(f"the answer has {len(text):,} characters; answer with the design alone")
    text = _INVISIBLE.sub("", text.replace("\r\n", "\n").translate(_SPACES))
    text = without_thoughts(without_quote(text, wanted), wanted)
    text = unboxed(text, wanted)
    if not text:
        raise Unreadable(EMPTY)
    return text


def _objects(text: str, wanted: str) -> tuple[list[dict[str, Any]], list[NotFound]]:
    """Return the different objects that have the key `wanted`, and what is wrong with others."""
    found: list[dict[str, Any]] = []
    errors: list[NotFound] = []
    at, tries = text.find("{"), 0
    while at != -1 and tries < _TRIES:
        tries += 1
        end = closing_brace(text, at)
        if end is None:
            if f'"{wanted}"' in text[at:]:
                errors.append(
                    Unreadable("the JSON object is not closed; the answer seems to be cut off")
                )
            at = text.find("{", at + 1)
            continue
        try:
            parsed = _unwrapped(_parsed(text[at:end]), wanted)
        except NotFound as error:
            if wanted in text[at:end]:
                errors.append(error)
        else:
            if isinstance(parsed, dict) and wanted in parsed and parsed not in found:
                found.append(parsed)
        at = text.find("{", end)
    return found, errors


def _parsed(text: str) -> Any:
    first = "the JSON cannot be read"
    for attempt in (text, _tidied(text)):
        try:
            return json.loads(
                attempt,
                strict=False,  # a line may break within a text
                object_pairs_hook=_without_repeats,
                parse_constant=_no_constant,
            )
        except json.JSONDecodeError as error:
            if attempt is text:
                where = f"line {error.lineno}, column {error.colno}"
                first = f"the JSON cannot be read: {error.msg} ({where})"
        except RecursionError:
            raise Unreadable("the JSON is nested too deeply") from None
        except ValueError as error:
            # An integer with thousands of digits.
            raise NotFound(f"the JSON cannot be read: {error}") from None
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError, RecursionError, MemoryError, TypeError):
        raise Unreadable(first) from None


def _tidied(text: str) -> str:
    """Return `text` without comments and trailing commas outside of strings."""
    pieces = re.findall(r'"(?:\\.|[^"\\])*"|/\*.*?\*/|(?:#|//)[^\n]*|[^"/#]+|.', text, re.DOTALL)
    pieces = ["" if piece[0] == "#" or piece[:2] in ("//", "/*") else piece for piece in pieces]
    return re.sub(r",(\s*[}\]])", r"\1", "".join(pieces))


def _without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in pairs:
        if name in found and found[name] != value:
            raise NotFound(f"the JSON gives {name!r} twice with different values")
        found[name] = value
    return found


def _no_constant(name: str) -> float:
    raise NotFound(f"the JSON holds {name}, which is no finite number")


def _unwrapped(parsed: Any, wanted: str, depth: int = 0) -> Any:
    """Return the object inside `{"design": {…}}` or `{"arguments": "{…}"}`."""
    if not isinstance(parsed, dict) or wanted in parsed or depth == _DEEPEST:
        return parsed
    inner = []
    for value in parsed.values():
        if isinstance(value, str) and value.lstrip().startswith("{") and wanted in value:
            value = _parsed(value)
        value = _unwrapped(value, wanted, depth + 1)
        if isinstance(value, dict) and wanted in value and value not in inner:
            inner.append(value)
    if len(inner) > 1:
        raise NotFound(f"the answer holds {len(inner)} different designs; answer with one")
    return inner[0] if inner else parsed
