"""What of the modules a reward uses, and what of them a reward cannot have."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from types import ModuleType
from typing import Any

from robomore.envs.reward_imports import NotOffered, offered_modules
from robomore.envs.reward_modules import OUTSIDE, SEEDED
from robomore.rewards.finding import Finding
from robomore.rewards.paths import path_of


def module_uses(tree: ast.Module) -> Iterator[Finding]:
    """Find each use of a module's attribute that a reward cannot have.

    Args:
        tree: of the whole text.
    """
    known = _names(tree)
    for node in ast.walk(tree):
        match node:
            case ast.ImportFrom(module=str(module), level=0) if module in offered_modules():
                for alias in node.names:
                    yield from _look(node, module, module, [alias.name])
            case ast.Attribute() | ast.Call():
                root, *names = path_of(node) or [""]
                if root in known:
                    yield from _look(node, known[root], root, names)


def _names(tree: ast.Module) -> dict[str, str]:
    """Return the modules that names stand for, also a name of a name."""
    offered = offered_modules()
    known = {"np": "numpy", "numpy": "numpy", "math": "math"}
    assigned: list[tuple[str, list[str]]] = []
    for node in ast.walk(tree):
        match node:
            case ast.Import(names=names):
                for one in names:
                    module = one.name if one.asname else one.name.partition(".")[0]
                    known[one.asname or module] = module
            case ast.ImportFrom(module=str(module), names=names):
                for one in names:
                    known[one.asname or one.name] = f"{module}.{one.name}"
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                assigned.append((name, path_of(value)))
            case ast.NamedExpr(target=ast.Name(id=name), value=value):
                assigned.append((name, path_of(value)))
    known = {name: module for name, module in known.items() if module in offered}
    for name, path in assigned:
        if path and path[0] in known:
            module = ".".join([known[path[0]], *path[1:]])
            if module in offered:
                known[name] = module
    return known


def _look(node: ast.stmt | ast.expr, module: str, root: str, names: list[str]) -> Iterator[Finding]:
    """Look up `names` one after the other, beginning at a module; stop at what is no module."""
    value: Any = offered_modules()[module]
    for place, name in enumerate(names):
        written = ".".join([root, *names[: place + 1]])
        if name.startswith("_") and not name.startswith("__"):
            said = f"cannot use `{written}`: it is private, and may keep what no checkpoint holds"
            yield Finding(node.lineno, "error", said)
            return
        if not isinstance(value, ModuleType):
            continue
        if value.__name__ == "numpy.random" and name in (*SEEDED, "Generator"):
            said = "a random reward makes training noisy; leave chance out"
            yield Finding(node.lineno, "warning", said)
        if value.__name__ == "numpy" and name in OUTSIDE:
            said = f"`{written}` reaches outside; a reward computes from numbers alone"
            yield Finding(node.lineno, "error", said)
            return
        try:
            value = getattr(value, name)
        except NotOffered as error:
            yield Finding(node.lineno, "error", f"cannot use `{written}`: {error.reason}")
            return
        except AttributeError:
            return  # The text may look for it in vain on purpose.
