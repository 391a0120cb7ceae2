"""What a few characters of a template make large: MuJoCo takes the memory before it refuses."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET

from robomore.errors import InputError

MOST_PARTS = 20_000
"""Elements of a template with all copies; the largest robot known has some hundreds."""

MOST_POINTS = 2**22
"""Points of a height field or a texture."""

_AREAS = {"hfield": ("nrow", "ncol"), "texture": ("width", "height")}
_BUFFERS = ("njmax", "nconmax", "nstack", "nuserdata", "nkey")
_COPIES = ("repeat", "replicate", "composite", "flexcomp")
_MORPHOLOGY = ("worldbody", "asset", "equality", "tendon", "actuator")
"""Sections that may depend on parameters. In others, such as <option>, a value that no check sees
could stop a simulation."""

_WHOLE = re.compile(r"[-+]?\d{1,9}")
_MEMORY = re.compile(r"-1|\d{1,9}|\d{1,6}[kK]|\d{1,3}[mM]")


def check_sizes(id: str, root: ET.Element) -> None:
    """Refuse a template that makes much more than it holds.

    Args:
        id: of the task, for the message.
        root: of the template.

    Raises:
        InputError: naming the element and the most that is allowed.
    """
    parts = _parts(id, root)
    if parts > MOST_PARTS:
        raise InputError(
            f"{id}: its template makes more than {MOST_PARTS:,} elements; use fewer copies"
        )
    for section in root:
        free = [] if section.tag in _MORPHOLOGY else section.iter()
        if any("{" in value for element in free for value in element.attrib.values()):
            raise InputError(
                f"{id}: <{section.tag}> in its template depends on parameters; write numbers there"
            )
    for element in root.iter():
        made = [math.prod(_whole(id, element, name) for name in _AREAS.get(element.tag, ()))]
        if element.tag == "size":
            made += [_whole(id, element, name) for name in _BUFFERS]
        if max(map(abs, made)) > MOST_POINTS:
            raise InputError(
                f"{id}: <{element.tag}> in its template asks for {max(made):,} values; at most "
                f"{MOST_POINTS:,} are made"
            )
        if not _MEMORY.fullmatch(element.get("memory", "-1").strip()):
            raise InputError(
                f"{id}: <{element.tag}> in its template asks for the memory "
                f"{element.attrib['memory'][:40]!r}; give at most 999M, or leave it out"
            )


def _parts(id: str, root: ET.Element) -> int:
    """Return the number of elements with their copies, or one beyond the limit."""
    total, waiting = 0, [(root, 1)]
    while waiting and total <= MOST_PARTS:
        element, times = waiting.pop()
        if element.tag in _COPIES:
            counts = element.get("count", "1").split()
            times *= math.prod(_whole(id, element, "count", one) for one in counts)
        total += max(times, 1)
        waiting += [(child, times) for child in element]
    return total


def _whole(id: str, element: ET.Element, name: str, text: str | None = None) -> int:
    text = (element.get(name, "1") if text is None else text).strip()
    if not _WHOLE.fullmatch(text):
        raise InputError(
            f"{id}: <{element.tag}> in its template has {name} {text[:40]!r}; give a whole number"
        )
    return int(text)
