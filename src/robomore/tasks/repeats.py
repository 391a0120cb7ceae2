"""Robots of no fixed number of parts: `<repeat>` elements in an MJCF template.

`<repeat count="{legs}" index="leg">` stands for its content as many times as the count says, with
the index counting from 0 in the placeholders within. A count of 0 leaves the content out, so that
nested repeats make limbs of some number of segments. MuJoCo never sees the element.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from copy import deepcopy
from functools import lru_cache

from robomore.errors import InvalidMorphology
from robomore.tasks.template import PLACEHOLDER, evaluate, names_used, parse

REPEAT = "repeat"
_INDEX = re.compile(r'<repeat\b[^>]*\bindex="(\w+)"')

_COUNT = re.compile(r'<repeat\b[^>]*\bcount="([^"]*)"')

MOST_PARTS = 2_000
"""Elements that all repeats of a template make together."""

MOST = 64
"""Times that anything can be repeated."""


def repeats(template: str) -> bool:
    """Return whether a template has a `<repeat>` element."""
    return f"<{REPEAT}" in template


def indices(template: str) -> set[str]:
    """Return the names that count within the repeats of a template."""
    return set(_INDEX.findall(template))


def expanded(template: str, values: Mapping[str, float]) -> str:
    """Return `template` with each `<repeat>` replaced by its content.

    Args:
        template: MJCF text with placeholders, of which only indices are filled in.
        values: numbers by name, those that counts refer to among them.

    Raises:
        InvalidMorphology: something is to be repeated more than `MOST` times.
        KeyError: a count uses a name that `values` lacks.
        ValueError: a count is not plain arithmetic, or the template is no XML.
    """
    if not repeats(template):
        return template
    return _expanded(template, tuple((name, values[name]) for name in _counted(template)))


@lru_cache(maxsize=64)
def _counted(template: str) -> tuple[str, ...]:
    """Return the names that the counts of a template use."""
    return tuple(sorted(names_used(" ".join(_COUNT.findall(template))) - indices(template)))


@lru_cache(maxsize=256)
def _expanded(template: str, counts: tuple[tuple[str, float], ...]) -> str:
    root = ET.fromstring(template)
    _expand(root, dict(counts), [0])
    return ET.tostring(root, encoding="unicode")


def _expand(parent: ET.Element, values: Mapping[str, float], made: list[int]) -> None:
    children = [one for child in parent for one in _made(child, values, made)]
    parent[:] = children
    for child in parent:
        _expand(child, values, made)


def _made(
    element: ET.Element, values: Mapping[str, float], made: list[int]
) -> Iterator[ET.Element]:
    """Yield an element, or the content of one that repeats; `made` counts the copies."""
    if element.tag != REPEAT:
        yield element
        return
    text = element.get("count", "1").strip("{}")
    count = round(evaluate(parse(text), values))
    if count > MOST:
        raise InvalidMorphology(f"{{{text}}} is {count}; at most {MOST} parts can be alike")
    for number in range(count):
        for child in element:
            made[0] += sum(1 for _ in child.iter())
            if made[0] > MOST_PARTS:
                raise InvalidMorphology(f"the repeats make more than {MOST_PARTS:,} parts")
            copied = deepcopy(child)
            if index := element.get("index"):
                _number(copied, index, number)
            yield from _made(copied, values, made)


def _number(element: ET.Element, index: str, number: int) -> None:
    """Put a number in the place of an index in all placeholders of an element."""
    word = re.compile(rf"\b{index}\b")

    def filled(match: re.Match[str]) -> str:
        # In a name it stands alone, and is written as the whole number that it is.
        if match[1].strip() == index:
            return str(number)
        return "{" + word.sub(str(number), match[1]) + "}"

    for part in element.iter():
        for name, text in part.attrib.items():
            part.set(name, PLACEHOLDER.sub(filled, text))
