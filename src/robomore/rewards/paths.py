"""Names in a syntax tree."""

from __future__ import annotations

import ast


def line_of(tree: ast.AST, name: str, function: str) -> int:
    """Return the line where a name first stands, in quotes if anywhere, else that of `function`."""
    quoted, plain, defined = [], [], [1]
    for node in ast.walk(tree):
        match node:
            case ast.Constant(value=str(found)) if found == name:
                quoted.append(node.lineno)
            case ast.Attribute(attr=found) | ast.Name(id=found) if found == name:
                plain.append(node.lineno)
            case ast.FunctionDef(name=found) if found == function:
                defined.append(node.lineno)
    return min(quoted or plain or defined[-1:])


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
