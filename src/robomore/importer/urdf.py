"""Reads a URDF file with MuJoCo, which knows neither packages nor a robot that moves freely."""

from __future__ import annotations

import re
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
    spec = mujoco.MjSpec.from_string(text)
    spec.compiler.balanceinertia = True
    return spec


def _located(name: str, urdf: Path) -> str:
    """Return a URDF's `filename="…"` with the path of the file that it means."""
    relative = re.sub(r"^(package|file)://", "", name)
    for folder in (urdf.parent, *urdf.resolve().parents):
        for candidate in (folder / relative, folder / relative.partition("/")[2]):
            if candidate.is_file():
                return f'filename="{candidate.resolve()}"'
    return f'filename="{name}"'
