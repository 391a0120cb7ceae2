"""Reads a URDF file with MuJoCo, which knows neither packages nor a robot that moves freely."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco

_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
_ELEMENT = re.compile(rb"<([A-Za-z][\w:.-]*)")


def is_urdf(content: bytes) -> bool:
    """Return whether a file's content is a URDF robot, whatever the file is called."""
    first = _ELEMENT.search(_COMMENT.sub(b"", content))
    return first is not None and first[1] == b"robot"


def read_urdf(path: Path) -> mujoco.MjSpec:
    """Return a URDF robot whose root is not welded to the world, as MuJoCo does by default.

    Raises:
        ValueError: MuJoCo does not read it.
    """
    text = path.read_text(encoding="utf-8")
    options = (
        '<mujoco><compiler fusestatic="false" discardvisual="true" strippath="false"/></mujoco>'
    )
    text = re.sub(r"<mujoco>.*?</mujoco>", "", text, flags=re.DOTALL)
    text = re.sub(r"(<robot\b[^>]*>)", rf"\1{options}", text, count=1)
    text = re.sub(r'filename="([^"]+)"', lambda found: _located(found[1], path), text)
    spec = mujoco.MjSpec.from_string(_without_footprint(text))
    spec.compiler.balanceinertia = True
    return spec


def _without_footprint(text: str) -> str:
    """Return a URDF without an empty root that the real one is fixed to.

    ROS has such a `base_footprint` on the ground, whose height says nothing of how a robot stands.
    """
    try:
        robot = ET.fromstring(text.encode())
    except ET.ParseError:
        return text  # MuJoCo says where
    links, joints = robot.findall("link"), robot.findall("joint")
    below = {found.get("link") for joint in joints for found in joint.findall("child")}
    for link in links:
        hung = [one for one in joints if _names(one, "parent") == link.get("name")]
        turned = [one.get("rpy", "0 0 0").split() for each in hung for one in each.iter("origin")]
        if (
            link.get("name") not in below
            and all(part.tag == "visual" for part in link)
            and [one.get("type") for one in hung] == ["fixed"]
            and not any(float(angle) for angles in turned for angle in angles)
        ):
            robot.remove(link)
            robot.remove(hung[0])
            return ET.tostring(robot, encoding="unicode")
    return text


def _names(joint: ET.Element, end: str) -> str:
    found = joint.find(end)
    return "" if found is None else found.get("link", "")


def _located(name: str, urdf: Path) -> str:
    """Return a URDF's `filename="…"` with the path of the file that it means."""
    relative = re.sub(r"^(package|file)://", "", name)
    for folder in (urdf.parent, *urdf.resolve().parents):
        for candidate in (folder / relative, folder / relative.partition("/")[2]):
            if candidate.is_file():
                return f'filename="{candidate.resolve()}"'
    return f'filename="{name}"'
