"""Says what is wrong with a line of a task file: the place, the value, and what may stand there."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator
from typing import Any, Literal, get_args, get_origin, get_type_hints

import msgspec

_KINDS = {
    "float": "a number",
    "int": "a whole number",
    "str": "a text in quotes",
    "array": "a list",
    "object": "a table",
    "bool": "true or false",
}


def explain(error: msgspec.ValidationError, table: type[msgspec.Struct], content: Any) -> str:
    """Return in words what `msgspec` says of a table.

    Args:
        error: that was raised.
        table: class that the content was to be converted to.
        content: as it was read.
    """
    said, _, place = str(error).partition(" - at `$")
    steps = re.findall(r"\.(\w+)|\[(\d+|\.\.\.)\]", place.rstrip("`"))
    where, found, kind = _follow(table, content, steps)
    if name := re.search(r"unknown field `(.*)`", said):
        known = [field.encode_name for field in msgspec.structs.fields(_struct(kind) or table)]
        near = difflib.get_close_matches(name[1], known, 1)
        hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
        return f"{where}`{name[1]}` is no line of it; {hint}"
    if name := re.search(r"missing required field `(.*)`", said):
        return f"{where}the line `{name[1]} = …` is missing"
    choices = list(_choices(kind))
    if choices:
        return f"{where}{found!r} is none of {', '.join(map(repr, choices))}"
    if wanted := re.match(r"Expected `([^`]*)`", said):
        words = [_KINDS.get(one.strip(), one.strip()) for one in wanted[1].split("|")]
        return f"{where}{found!r} is not {' or '.join(words)}"
    return f"{where}{said}"


def _follow(kind: Any, found: Any, steps: list[tuple[str, str]]) -> tuple[str, Any, Any]:
    """Return the place in words, what stands there, and the type that is wanted."""
    where = ""
    for name, number in steps:
        if name:
            kind = get_type_hints(_struct(kind))[name] if _struct(kind) else None
            found = found.get(name) if isinstance(found, dict) else None
            where += f"{name}, "
        else:
            inner = get_args(kind)
            kind = inner[0] if inner else None
            at = int(number) if number.isdecimal() else 0
            many = isinstance(found, list) and at < len(found)
            found = found[at] if many and number.isdecimal() else None
            called = found.get("name") if isinstance(found, dict) else None
            where += f"number {at + 1}{f' ({called})' if called else ''}, "
    return f"{where.removesuffix(', ')}: " if where else "", found, kind


def _struct(kind: Any) -> type[msgspec.Struct] | None:
    options = (kind, *get_args(kind))
    return next(
        (it for it in options if isinstance(it, type) and issubclass(it, msgspec.Struct)), None
    )


def _choices(kind: Any) -> Iterator[str]:
    if get_origin(kind) is Literal:
        yield from get_args(kind)
    else:
        for inner in get_args(kind):
            yield from _choices(inner)
