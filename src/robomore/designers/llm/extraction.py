"""Finds the JSON or the Python code in the answer of a language model.

It accepts fences, prose, comments, trailing commas and thoughts around it, as long as the answer
has only one possible meaning.
"""

from __future__ import annotations

import ast
import json
import re
import textwrap
from typing import Any

LONGEST = 200_000
"""A longer answer is refused. No reasonable answer has so many characters."""
_TRIES = 40
"""Opening braces that are tried. Prose has a few, hostile text has thousands."""
_LONGEST_OBJECT = 20_000
"""Characters within which an object must close."""

_THOUGHT_END = re.compile(r"</(?:think|thinking|thought|reasoning)>", re.IGNORECASE)
_THOUGHT_START = re.compile(r"<(?:think|thinking|thought|reasoning)>", re.IGNORECASE)
_FENCE = re.compile(r"(?P<fence>`{3,}|~{3,})\s*[\w+-]*")
_CODE_LINE = re.compile(
    r"(?:async\s+def|def|class)\s+\w+|(?:import|from)\s+[\w.]+|@\w|#|[A-Za-z_]\w*\s*(?::[^=]+)?=[^=]|"
    r'["\']{3}|[)\]}]|if\s+__name__|try:|except\b.*:'
)


class NotFound(Exception):
    """The answer does not hold what was asked for. The message says what is wrong."""


def without_thoughts(text: str) -> str:
    """Return `text` without the thoughts that a reasoning model writes before its answer."""
    # Some servers remove the opening tag. A truncated answer may lack the closing tag.
    after = _THOUGHT_START.split(_THOUGHT_END.split(text)[-1])[0].strip()
    return after or _THOUGHT_START.split(text)[0].strip()


def find_object(text: str, wanted: str) -> dict[str, Any]:
    """Return the JSON object in `text` that has the key `wanted`.

    Raises:
        NotFound: there is no such object, it is invalid, or several differ.
    """
    text = _cleared(text)
    found: list[dict[str, Any]] = []
    errors: list[str] = []
    at, tries = text.find("{"), 0
    while at != -1 and tries < _TRIES:
        tries += 1
        end = _closing(text, at)
        if end is None:
            if f'"{wanted}"' in text[at:]:
                errors.append("the JSON object is not closed; the answer seems to be cut off")
            at = text.find("{", at + 1)
            continue
        try:
            parsed = _unwrapped(_parsed(text[at:end]), wanted)
        except NotFound as error:
            if wanted in text[at:end]:
                errors.append(str(error))
        else:
            if isinstance(parsed, dict) and wanted in parsed and parsed not in found:
                found.append(parsed)
        at = text.find("{", end)
    if len(found) > 1:
        raise NotFound(f"the answer holds {len(found)} different designs; answer with one")
    if found:
        return found[0]
    raise NotFound(*errors[:1] or [f'the answer holds no JSON object with "{wanted}"'])


def find_code(text: str, wanted: str) -> tuple[str, bool]:
    """Return the Python code in `text` that defines the function `wanted`, or any other function,
    and whether its end was marked.

    Raises:
        NotFound: there is no code, or there are several versions of it.
    """
    text = _quoted(_cleared(text), wanted)
    definition = re.compile(rf"\bdef\s+{re.escape(wanted)}\b")
    blocks = _blocks(text)
    defining = list(dict.fromkeys(block for block in blocks if definition.search(block[0])))
    if len({code for code, _ in defining}) > 1:
        raise NotFound(
            f"the answer holds {len(defining)} code blocks that define `{wanted}`; answer with one"
        )
    if defining:
        return defining[0]
    code = (block for block in blocks if re.search(r"\bdef\s+\w+", block[0]))
    return next(code, None) or (_bare(text, wanted), False)


def _blocks(text: str) -> list[tuple[str, bool]]:
    """Return the text between fences, and whether the closing fence is there."""
    found: list[tuple[str, bool]] = []
    block: list[str] = []
    fence = ""
    for line in text.split("\n"):
        stripped = line.strip().strip("'\"")
        opening = _FENCE.match(stripped)
        closing = opening and opening["fence"] == stripped
        if fence and closing and stripped.startswith(fence):
            found.append((_dedented(block), True))
            block, fence = [], ""
        elif fence:
            block.append(line)
        elif opening:
            fence = opening["fence"]
    return [*found, (_dedented(block), False)] if fence else found


def _dedented(lines: list[str]) -> str:
    return textwrap.dedent("\n".join(lines)).strip("\n")


def _cleared(text: str) -> str:
    if len(text) > LONGEST:
        raise NotFound(f"the answer has {len(text):,} characters; answer with the design alone")
    text = without_thoughts(text.replace("\r\n", "\n").replace("\ufeff", ""))
    if not text:
        raise NotFound("the answer is empty")
    return text


def _closing(text: str, start: int) -> int | None:
    """Return the end of the braces that open at `start`, with regard to strings and comments."""
    depth, at, quote = 0, start, ""
    while at < min(len(text), start + _LONGEST_OBJECT):
        character = text[at]
        if quote:
            if character == "\\":
                at += 1
            elif character == quote:
                quote = ""
        elif character == '"':
            quote = character
        elif character == "#" or text.startswith("//", at):
            at = text.find("\n", at)
            if at == -1:
                return None
        elif character == "{":
            depth += 1
        elif character == "}":
            depth -= 1
            if depth == 0:
                return at + 1
        at += 1
    return None


def _parsed(text: str) -> Any:
    first = "the JSON cannot be read"
    for attempt in (text, _tidied(text)):
        try:
            return json.loads(
                attempt, object_pairs_hook=_without_repeats, parse_constant=_no_constant
            )
        except json.JSONDecodeError as error:
            if attempt is text:
                where = f"line {error.lineno}, column {error.colno}"
                first = f"the JSON cannot be read: {error.msg} ({where})"
        except RecursionError:
            raise NotFound("the JSON is nested too deeply") from None
        except ValueError as error:
            # An integer with thousands of digits.
            raise NotFound(f"the JSON cannot be read: {error}") from None
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError, RecursionError, MemoryError, TypeError):
        raise NotFound(first) from None


def _tidied(text: str) -> str:
    """Return `text` without comments and trailing commas outside of strings."""
    pieces = re.split(r'("(?:\\.|[^"\\])*")', text)
    for index in range(0, len(pieces), 2):
        pieces[index] = re.sub(r"(?:#|//)[^\n]*", "", pieces[index])
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


def _unwrapped(parsed: Any, wanted: str) -> Any:
    """Return the object inside `{"design": {…}}`."""
    if isinstance(parsed, dict) and wanted not in parsed:
        inner = [value for value in parsed.values() if isinstance(value, dict) and wanted in value]
        if len(inner) > 1:
            raise NotFound(f"the answer holds {len(inner)} different designs; answer with one")
        if inner:
            return inner[0]
    return parsed


def _quoted(text: str, wanted: str) -> str:
    """Return code that is the value of a JSON object or a Python string, or else `text`."""
    if text[0] == "{":
        try:
            found = json.loads(text, strict=False)
        except (ValueError, RecursionError):
            return text
        values = [value for value in found.values() if isinstance(value, str) and wanted in value]
        return values[0] if len(values) == 1 else text
    if text[0] in "'\"" and text[-1] == text[0]:
        try:
            found = ast.literal_eval(text)
        except (ValueError, SyntaxError, RecursionError, MemoryError):
            # A quote around fenced code of several lines.
            return text[1:-1]
        return found.strip() if isinstance(found, str) and found.strip() else text
    return text


def _bare(text: str, wanted: str) -> str:
    """Return code without fences from the prose around it."""
    lines = text.split("\n")
    first = re.compile(r"\s*(?:(?:async\s+)?def|class)\s+\w+\s*[(:]")
    start = next((index for index, line in enumerate(lines) if first.match(line)), None)
    if start is None:
        raise NotFound(f"the answer holds no Python code that defines `{wanted}`")
    margin = len(lines[start]) - len(lines[start].lstrip())
    while start > 0 and _is_code(lines[start - 1], margin) and lines[start - 1].strip():
        start -= 1
    whole = _dedented(lines[start:])
    try:
        ast.parse(whole)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        end = start
        while end < len(lines) and _is_code(lines[end], margin):
            end += 1
        return _dedented(lines[start:end])
    return whole


def _is_code(line: str, margin: int) -> bool:
    indent = len(line) - len(line.lstrip())
    return not line.strip() or indent > margin or bool(_CODE_LINE.match(line.strip()))
