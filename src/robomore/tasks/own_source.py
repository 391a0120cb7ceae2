"""The text of a module and of all that it imports of its author's, found without importing it.

An environment's module imports MuJoCo, which is slow and absent on machines that only read runs.
"""

from __future__ import annotations

import ast
import importlib.util
import sys
from collections.abc import Callable
from importlib.abc import InspectLoader
from importlib.machinery import PathFinder

_VERSIONED = sys.stdlib_module_names | {"gymnasium", "mujoco", "numpy", "robomore", "scipy"}
"""Packages that are not followed: a run records their versions."""


def own_source(module: str, skip: Callable[[str], bool] = lambda top: False) -> dict[str, str]:
    """Return the texts of a module and of its author's modules that it imports, by name.

    Args:
        module: full name of a module. Nothing is returned for one that cannot be found.
        skip: says of a package or top module that is imported whether to leave it out.
    """
    found: dict[str, str] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        text = None if name in found else _text(name)
        if text is None:
            continue
        found[name] = text
        tops = ((one, one.partition(".")[0]) for one in _imports(name, text))
        waiting += [one for one, top in tops if top not in _VERSIONED and not skip(top)]
    return dict(sorted(found.items()))


def _imports(module: str, text: str) -> list[str]:
    """Return the full names of what a module may import; some of them are no modules."""
    try:
        tree = ast.parse(text)
    except SyntaxError:
        return []
    found: list[str] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            parts = module.split(".")[: -node.level] if node.level else []
            source = ".".join([*parts, *filter(None, [node.module])])
            found += [source, *(f"{source}.{alias.name}" for alias in node.names)]
    return found


def _text(module: str) -> str | None:
    """Return a module's text; `importlib.util.find_spec` alone would import its packages."""
    top, *rest = module.split(".")
    try:
        spec = importlib.util.find_spec(top)
        for number in range(len(rest)):
            if spec is None or spec.submodule_search_locations is None:
                return None
            name = ".".join([top, *rest[: number + 1]])
            spec = PathFinder.find_spec(name, list(spec.submodule_search_locations))
        if spec is None or not isinstance(spec.loader, InspectLoader):
            return None
        return spec.loader.get_source(module)
    except (ImportError, ValueError, OSError, SyntaxError, UnicodeDecodeError):
        return None
