"""The text of a class's module and of its base classes' modules, found without importing them.

An environment's module imports MuJoCo, which is slow and absent on machines that only read runs.
"""

from __future__ import annotations

import ast
import importlib.util
import sys
from importlib.abc import InspectLoader
from importlib.machinery import ModuleSpec, PathFinder

_OUTSIDE = sys.stdlib_module_names | {"gymnasium", "mujoco", "numpy"}
"""Packages that are not followed: a run records their versions."""


def class_sources(module: str, name: str) -> dict[str, str]:
    """Return the texts of the modules that define a class and its base classes, by module.

    Args:
        module: full name of the module that the class is imported from.
        name: of the class.

    Returns:
        An empty dictionary if the module cannot be found.
    """
    found: dict[str, str] = {}
    waiting, seen = [(module, name)], set()
    while waiting:
        place = waiting.pop()
        if place in seen or place[0].partition(".")[0] in _OUTSIDE:
            continue
        seen.add(place)
        text = _source(place[0])
        if text is None:
            continue
        found[place[0]] = text
        waiting += _leads_to(place[0], text, place[1])
    return dict(sorted(found.items()))


def _leads_to(module: str, text: str, name: str) -> list[tuple[str, str]]:
    """Return module and name of the base classes of `name`, or where `name` is imported from."""
    try:
        statements = ast.parse(text).body
    except SyntaxError:
        return []
    imported: dict[str, tuple[str, str]] = {}
    modules: dict[str, str] = {}
    for node in statements:
        match node:
            case ast.ImportFrom(names=aliases):
                source = _absolute(module, node)
                imported |= {one.asname or one.name: (source, one.name) for one in aliases}
            case ast.Import(names=aliases):
                modules |= {one.asname or one.name: one.name for one in aliases}
    for node in statements:
        if isinstance(node, ast.ClassDef) and node.name == name:
            return [
                place
                for base in node.bases
                if (place := _place(ast.unparse(base), module, imported, modules)) is not None
            ]
    return [imported[name]] if name in imported else []


def _place(
    base: str, module: str, imported: dict[str, tuple[str, str]], modules: dict[str, str]
) -> tuple[str, str] | None:
    """Return module and name of a base class that is written as `base` in `module`."""
    before, _, name = base.partition("[")[0].rpartition(".")
    if not before:
        return imported.get(name, (module, name))
    if before in modules:
        return modules[before], name
    if before in imported:  # `from package import module`
        return ".".join(imported[before]), name
    return None


def _absolute(module: str, node: ast.ImportFrom) -> str:
    if not node.level:
        return node.module or ""
    spec = _spec(module)
    package = module if spec and spec.submodule_search_locations else module.rpartition(".")[0]
    for _ in range(node.level - 1):
        package = package.rpartition(".")[0]
    return f"{package}.{node.module}" if node.module else package


def _source(module: str) -> str | None:
    spec = _spec(module)
    if spec is None or not isinstance(spec.loader, InspectLoader):
        return None
    try:
        return spec.loader.get_source(module)
    except (ImportError, OSError, SyntaxError, UnicodeDecodeError):
        return None


def _spec(module: str) -> ModuleSpec | None:
    """Find a module; `importlib.util.find_spec` would import the packages that it lies in."""
    top, *rest = module.split(".")
    try:
        spec = importlib.util.find_spec(top)
    except (ImportError, ValueError):
        return None
    name = top
    for part in rest:
        if spec is None or spec.submodule_search_locations is None:
            return None
        name = f"{name}.{part}"
        spec = PathFinder.find_spec(name, list(spec.submodule_search_locations))
    return spec
