"""Takes the frames out of an MJCF tree: compiled places hold without them."""

from __future__ import annotations

import xml.etree.ElementTree as ET

_CLASS = {"body": "childclass", "frame": "childclass"} | dict.fromkeys(
    ("geom", "joint", "site", "camera", "light"), "class"
)
"""The attribute with the class of defaults, of each part that has one."""


def hoist(element: ET.Element) -> None:
    """Move what stands in frames into the body itself, with the class that its frame gives it."""
    for frame in element.findall("frame"):
        if given := frame.get("childclass"):
            for part in frame:
                name = _CLASS.get(part.tag)
                if name and not part.get(name):
                    part.set(name, given)
        hoist(frame)
        at = list(element).index(frame)
        element.remove(frame)
        for offset, child in enumerate(list(frame)):
            element.insert(at + offset, child)
