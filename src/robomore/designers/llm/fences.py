"""Finds the blocks between fences in Markdown."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence

_DEEPEST = 3
"""Fences around fences that are looked into."""

_OPENING = re.compile(r"(?<![`~])(?P<fence>`{3,}+|~{3,}+)[ \t]*(?P<info>[^`~]*)$")
_LANGUAGE = re.compile(r"\{?\.?(?:python3?|py|json)\b")
_BEGINS_CODE = re.compile(r"(?:def|import|from|class)\s|[@{]")
_STRING = re.compile(
    r"""\"{3}|'{3}|\#|"(?:\\.|[^"\\]){0,500}"|'(?:\\.|[^'\\]){0,500}'""",
)

Block = tuple[str, bool]
"""The text between two fences, and whether the closing fence is there."""


def blocks_of(text: str) -> list[Block]:
    """Return the blocks of code between fences.

    A fence within a string of three quotes is part of the code. A closing fence may also stand at
    the end of the last line of code, and an opening one at the end of a line of prose.
    """
    found: list[Block] = []
    block: list[str] = []
    fence = quotes = ""
    for line in text.split("\n"):
        stripped = line.strip().strip("'\"")
        if not fence:
            opening = _opening(line.rstrip().rstrip("'\""))
            if opening:
                fence, first = opening
                block = [first] if first else []
                quotes = _open_quotes(first, "")
            continue
        before = quotes
        body = line.rstrip()
        if not before and stripped.startswith(fence) and not stripped.strip(fence[0]):
            found.append((dedented(block), True))
            block, fence = [], ""
            continue
        if body.endswith(fence):
            code = body.rstrip(fence[0])
            if not _open_quotes(code, before):
                found.append((dedented([*block, code]), True))
                block, fence = [], ""
                continue
        quotes = _open_quotes(line, before)
        block.append(line)
    return [*found, (dedented(block), False)] if fence else found


def blocks_within(block: Block, depth: int = 0) -> list[Block]:
    """Return the blocks of code in a block of Markdown, or else the block itself."""
    code, closed = block
    if depth == _DEEPEST or _BEGINS_CODE.match(code.lstrip()):
        return [block]
    inner = [(text, whole or closed) for text, whole in blocks_of(code)]
    return [one for block in inner for one in blocks_within(block, depth + 1)] or [block]


def dedented(lines: Sequence[str]) -> str:
    return textwrap.dedent("\n".join(lines)).strip("\n")


def _opening(line: str) -> tuple[str, str] | None:
    """Return the fence that opens in `line`, and the code that follows it in the same line."""
    found = _OPENING.search(line)
    if found is None:
        return None
    info = found["info"].strip()
    language = _LANGUAGE.match(info)
    code = info[language.end() :].strip() if language else info
    code = code if _BEGINS_CODE.match(code) else ""
    prose = line[: found.start()].strip(" \t'\">*-.)0123456789")
    # Prose may speak of a fence without opening one.
    return None if prose and not language else (found["fence"], code)


def _open_quotes(line: str, quotes: str) -> str:
    """Return the three quotes within which `line` ends, if it begins within `quotes`."""
    at = 0
    while True:
        if quotes:
            end = line.find(quotes, at)
            if end == -1:
                return quotes
            at, quotes = end + 3, ""
        token = _STRING.search(line, at)
        if token is None or token[0] == "#":
            return ""
        at = token.end()
        if token[0] in ('"""', "'''"):
            quotes = token[0]
