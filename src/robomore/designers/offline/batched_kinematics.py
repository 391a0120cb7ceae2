"""Computes the rest poses of many morphologies at once from a task's MJCF template.

It needs no simulator: the template says where each limb begins and ends.
"""

from __future__ import annotations

import ast
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.designers.offline.rest_pose import RestPose
from robomore.tasks.template import evaluate

Array = NDArray[np.float64]

_FUNCTIONS: dict[str, Callable[..., Any]]
_FUNCTIONS = {
    "sqrt": np.sqrt,
    "abs": np.abs,
    "min": np.minimum,
    "max": np.maximum,
    "sin": np.sin,
    "cos": np.cos,
}
_TOKEN = re.compile(r"\{([^{}]+)\}|(\S+)")


class BatchedKinematics:
    """The limbs of a template as expressions over parameter names.

    Args:
        template: MJCF text with `{expression}` placeholders.
        constants: numbers that the template uses besides the parameters.

    Raises:
        ValueError: the template uses a feature that is not read here: rotated bodies, or solids
            other than spheres and capsules between two points.
    """

    def __init__(self, template: str, constants: Mapping[str, float]) -> None:
        self._constants = constants
        self._limbs: list[tuple[list[ast.expr], list[ast.expr], ast.expr]] = []
        self._roots: list[list[ast.expr]] = []
        self._legs: list[tuple[int, ...]] = []
        self._hinges: list[tuple[list[float], int]] = []
        world = ET.fromstring(template).find("worldbody")
        for torso in [] if world is None else world.findall("body"):
            here, _ = self._read(torso, [ast.Constant(0.0)] * 3)
            for child in torso.findall("body"):
                self._follow(child, here)
        if not self._limbs:
            raise ValueError("no limbs found below <worldbody>")

    def rest_pose(self, columns: Mapping[str, Array]) -> RestPose:
        """Return the rest pose of n morphologies, given as parameter name -> values (n,)."""
        count = len(next(iter(columns.values())))
        values = {**self._constants, **columns}

        def stacked(trees: list[ast.expr]) -> Array:
            return np.stack(
                [np.broadcast_to(evaluate(t, values, _FUNCTIONS), (count,)) for t in trees], axis=-1
            )

        ends = [np.stack([stacked(start), stacked(end)], axis=1) for start, end, _ in self._limbs]
        roots = [stacked(root) for root in self._roots]
        return RestPose(
            ends=np.stack(ends, axis=1),
            radii=stacked([radius for *_, radius in self._limbs]),
            roots=np.stack(roots, axis=1) if roots else np.zeros((count, 0, 3)),
            legs=tuple(self._legs),
            axes=np.array([axis for axis, _ in self._hinges]).reshape(-1, 3),
            swung=tuple(limb for _, limb in self._hinges),
        )

    def _follow(self, first: ET.Element, origin: list[ast.expr]) -> None:
        """Read the leg that starts with body `first`; of a branching leg, only the first branch."""
        root: list[ast.expr] = []
        leg: list[int] = []
        body: ET.Element | None = first
        while body is not None:
            origin, limbs = self._read(body, origin)
            root = root or origin
            leg.extend(limbs)
            for joint in body.findall("joint"):
                if joint.get("type", "hinge") == "hinge" and limbs:
                    axis = [float(number) for number in joint.get("axis", "0 0 1").split()]
                    self._hinges.append((axis, limbs[0]))
            body = body.find("body")
        if leg:
            self._roots.append(root)
            self._legs.append(tuple(leg))

    def _read(self, body: ET.Element, origin: list[ast.expr]) -> tuple[list[ast.expr], list[int]]:
        """Add the limbs of one body, and return its position and the indices of its limbs."""
        for attribute in ("quat", "axisangle", "euler", "xyaxes", "zaxis"):
            if attribute in body.attrib:
                raise ValueError(f"body {body.get('name')!r} is rotated by {attribute}")
        here = _added(origin, _numbers(body.get("pos", "0 0 0")))
        before = len(self._limbs)
        for geom in body.findall("geom"):
            size = _numbers(geom.get("size", ""))
            if not size:
                raise ValueError(f"a geom of body {body.get('name')!r} has no size")
            if "fromto" in geom.attrib:
                both = _numbers(geom.attrib["fromto"])
                self._limbs.append((_added(here, both[:3]), _added(here, both[3:]), size[0]))
            elif geom.get("type", "sphere") == "sphere":
                centre = _added(here, _numbers(geom.get("pos", "0 0 0")))
                self._limbs.append((centre, centre, size[0]))
            else:
                raise ValueError(f"geom {geom.get('name')!r} is neither sphere nor fromto capsule")
        return here, list(range(before, len(self._limbs)))


def _numbers(text: str) -> list[ast.expr]:
    """Parse `0 {leg_x} {-leg_y}` into one expression per number."""
    return [
        ast.parse(braced.strip() or plain, mode="eval").body
        for braced, plain in _TOKEN.findall(text)
    ]


def _added(left: list[ast.expr], right: list[ast.expr]) -> list[ast.expr]:
    return [ast.BinOp(a, ast.Add(), b) for a, b in zip(left, right, strict=True)]
