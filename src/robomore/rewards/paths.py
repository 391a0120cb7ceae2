"""Names in a syntax tree."""

from __future__ import annotations

import ast


def path_of(node: ast.AST) -> list[str]:
    """Return `["self", "data", "qpos"]` for `self.data.qpos[2:]`, empty for anything else.

    `getattr(self, "data")` is read as `self.data`.
    """
    names: list[str] = []
    while True:
        match node:
            case ast.Attribute(value=value, attr=name):
                names.append(name)
            case ast.Call(
                func=ast.Name(id="getattr"), args=[value, ast.Constant(value=str(name)), *_]
            ):
                names.append(name)
            case ast.Subscript(value=value):
                pass
            case ast.Name(id=root):
                return [root, *reversed(names)]
            case _:
                return []
        node = value
