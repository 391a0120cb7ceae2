"""Says in one line, with the place, what is wrong with a robot's file, above all to MuJoCo."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

from robomore.errors import InputError

_LONGEST = 1_000
"""Characters of what MuJoCo says: it repeats names of any length."""

_LINE = re.compile(r", line (\d+)|Line number=(\d+)")
_ELEMENT = re.compile(r"(?:Element '|XMLElement name=)([^'\s]+)")
_NAME = re.compile(r"Element name '([^']+)'")
_PREFIX = re.compile(r"^(?:(?:XML Error|Error|Schema violation|ParseXML):\s*)+")
_UNPARSED = re.compile(r"XML_ERROR_(\w+)")


def xml_fault(path: Path, error: Exception) -> str:
    """Return what is wrong with a robot's file, with its name, the line and the element.

    Args:
        path: of the file.
        error: of MuJoCo, or of ours where it reads what it should not.
    """
    said = str(error)[:_LONGEST].strip()
    first, _, place = said.partition("\n")
    what = _PREFIX.sub("", first).strip()
    if unparsed := _UNPARSED.search(place):
        what = f"it is not well-formed XML ({unparsed[1].lower().replace('_', ' ')})"
    if not place:
        return f"{path} is no robot that MuJoCo reads: {what}"
    line, element, name = (found.search(place) for found in (_LINE, _ELEMENT, _NAME))
    where = f", line {number}" if line and (number := int(line[1] or line[2])) else ""
    part = f" in <{element[1]}>" if element else f" in {name[1]!r}" if name else ""
    # Where nothing is known of the place, all that is said may help.
    told = what + part if where or part else " ".join(said.split())
    return f"{path}{where}: MuJoCo does not read it: {told}; correct the file"


def refuse_braces(path: Path, root: ET.Element) -> None:
    """Refuse a robot whose own texts would be taken for the placeholders of a template.

    Args:
        path: of the robot's file.
        root: of the robot as MJCF.

    Raises:
        InputError: naming the text.
    """
    for element in root.iter():
        for attribute, text in element.attrib.items():
            if "{" in text or "}" in text:
                raise InputError(
                    f"{path}: a <{element.tag}> has {attribute}={text[:80]!r}; braces stand for "
                    "numbers in a task's template, so write this without braces wherever the file "
                    "has it"
                )
