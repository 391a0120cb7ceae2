"""The solids of a robot, read from its MJCF template: what its volume is the sum of.

It needs no simulator. Of each link count the geoms that can touch something; of a robot that has
none of these, all of them.
"""

from __future__ import annotations

import ast
import math
import random
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from types import CodeType

from robomore.tasks.geometry import Capsule, Shape, Solid, Sphere
from robomore.tasks.template import FUNCTIONS, check_arithmetic, names_used, parse

Values = Mapping[str, float]

_TOKEN = re.compile(r"\{([^{}]+)\}|(\S+)")
_SCOPE = {**FUNCTIONS, "__builtins__": {}}
_ANALYTIC = ("sin", "cos")
"""Of the functions of a template, those without kinks and edges."""

_THREE_SIZES = ("box", "ellipsoid")

_PROBES = 3
"""Points at which the sizes of capsules are compared."""

_READ = ("type", "size", "fromto", "contype", "conaffinity", "mesh", "scale")


@dataclass(frozen=True, slots=True)
class _Geom:
    """Equal geoms: their type, and code that gives their sizes, and the two ends if it has any.

    `smooth` says whether all of these are analytic functions of the parameters.
    """

    kind: str
    sizes: CodeType
    has_ends: bool
    mesh_volume: float
    smooth: bool
    count: int = 1

    def shape(self, values: Values) -> Shape:
        size = list(eval(self.sizes, dict(_SCOPE), values))
        if self.has_ends:
            points = size[-6:]
            half = math.dist(points[:3], points[3:]) / 2
            # As MuJoCo reads it, whatever other sizes there are.
            size = [size[0], size[0], half] if self.kind in _THREE_SIZES else [size[0], half]
        if self.kind == "sphere":
            return Sphere(size[0])
        if self.kind == "capsule":
            return Capsule(size[0], 2 * size[1], self.count)
        if self.kind == "mesh":
            return Solid(abs(math.prod(size)) * self.mesh_volume)
        return Solid(volume_of(self.kind, size))


def solids(
    template: str, values: Values, mesh_volumes: Mapping[str, float] | None = None
) -> tuple[Shape, ...]:
    """Return the solids of one morphology.

    Args:
        template: MJCF text with placeholders.
        values: parameters and constants by name.
        mesh_volumes: enclosed volume in m³ of each mesh at scale 1, by name.
    """
    volumes = tuple(sorted((mesh_volumes or {}).items()))
    return tuple(geom.shape(values) for geom in _geoms(template, volumes))


def volume_of(kind: str, size: Sequence[float]) -> float:
    """Return the volume in m³ of a geom from MuJoCo's sizes of its type, in m.

    Raises:
        ValueError: there is no such solid.
    """
    if kind == "sphere":
        return Sphere(size[0]).volume
    if kind == "capsule":
        return Capsule(size[0], 2 * size[1]).volume
    if kind == "cylinder":
        return math.pi * size[0] ** 2 * 2 * size[1]
    if kind == "box":
        return 8 * math.prod(size[:3])
    if kind == "ellipsoid":
        return 4 / 3 * math.pi * math.prod(size[:3])
    raise ValueError(f"a {kind} has no volume; use a solid")


@lru_cache(maxsize=64)
def _geoms(template: str, mesh_volumes: tuple[tuple[str, float], ...]) -> tuple[_Geom, ...]:
    root = ET.fromstring(template)
    classes: dict[str, dict[str, dict[str, str]]] = {"": {}}
    for default in root.findall("default"):
        _read_defaults(default, {}, classes, top=True)
    scales = {
        mesh.get("name", ""): {**classes[""].get("mesh", {}), **mesh.attrib}.get("scale", "1 1 1")
        for mesh in root.iterfind("asset/mesh")
    }
    world = root.find("worldbody")
    bodies = [] if world is None else world.findall("body")
    found = [geom for body in bodies for geom in _of_body(body, "", classes)]
    touching = [one for one in found if one.get("contype") != "0" or one.get("conaffinity") != "0"]
    volumes = dict(mesh_volumes)
    made = []
    for one in touching or found:
        kind = one.get("type", "mesh" if "mesh" in one else "sphere")
        size = scales.get(one.get("mesh", ""), "1 1 1") if kind == "mesh" else one.get("size", "")
        volume = volumes.get(one.get("mesh", ""), 0.0)
        ends = one.get("fromto", "")
        sizes = _trees(f"{size} {ends}")
        smooth = all(map(_is_smooth, sizes))
        made.append(_Geom(kind, _code(sizes), bool(ends), volume, smooth))
    return _grouped(made, sorted(names_used(template)))


def _grouped(geoms: Sequence[_Geom], names: Sequence[str]) -> tuple[_Geom, ...]:
    """Return geoms with capsules that are equal whatever the parameters together.

    Analytic functions that agree at points without any pattern agree everywhere. Others do not:
    `min(a, b)` is `a` at some points and `b` at others, so capsules of such sizes stay apart.
    """
    draws = random.Random(0)  # the same points in every process
    probes = [{name: draws.uniform(0.2, 0.9) for name in names} for _ in range(_PROBES)]
    found: dict[object, _Geom] = {}
    for number, geom in enumerate(geoms):
        key: object = number
        if geom.kind == "capsule" and geom.smooth:
            sizes = [geom.shape(values) for values in probes]
            key = tuple(f"{one.volume:.9g} {one.radius:.9g}" for one in sizes)
        found[key] = replace(geom, count=found[key].count + 1) if key in found else geom
    return tuple(found.values())


def _read_defaults(
    element: ET.Element,
    above: Mapping[str, Mapping[str, str]],
    classes: dict[str, dict[str, dict[str, str]]],
    top: bool = False,
) -> None:
    own = {tag: dict(values) for tag, values in above.items()}
    for part in element:
        if part.tag in ("geom", "mesh"):
            own.setdefault(part.tag, {}).update(part.attrib)
    classes[element.get("class", "")] = own
    if top:
        classes[""] = own
    for inner in element.findall("default"):
        _read_defaults(inner, own, classes)


def _of_body(
    body: ET.Element, inherited: str, classes: Mapping[str, Mapping[str, Mapping[str, str]]]
) -> Iterator[dict[str, str]]:
    within = body.get("childclass", inherited)
    for part in body:
        if part.tag == "geom":
            defaults = classes.get(part.get("class", within), {}).get("geom", {})
            merged = {**defaults, **part.attrib}
            yield {name: merged[name] for name in _READ if name in merged}
        elif part.tag in ("body", "frame"):
            yield from _of_body(part, within, classes)


def _trees(text: str) -> list[ast.expr]:
    """Return the arithmetic of each of the numbers of attributes.

    Raises:
        ValueError: one of them is not plain arithmetic.
    """
    trees = [parse(braced or plain) for braced, plain in _TOKEN.findall(text)]
    for tree in trees:
        check_arithmetic(tree)
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant):
                # As `fill` counts, too: whole numbers of Python grow without limit.
                node.value = float(node.value)  # type: ignore[arg-type]
    return trees


def _is_smooth(tree: ast.expr) -> bool:
    """Return whether arithmetic is analytic: `sqrt(x**2)`, too, has a kink, where x is 0."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") not in _ANALYTIC:
            return False
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
            power = node.right
            if not (isinstance(power, ast.Constant) and float(power.value).is_integer()):  # type: ignore[arg-type]
                return False
    return True


def _code(trees: Sequence[ast.expr]) -> CodeType:
    """Return code that gives a tuple of the numbers."""
    whole = ast.Expression(ast.Tuple(list(trees), ast.Load()))
    return compile(ast.fix_missing_locations(whole), "<template>", "eval")
