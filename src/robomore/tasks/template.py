"""MJCF templates: `{placeholders}` that are small arithmetic over parameter names.

A template stays readable as a robot (`pos="{hip_x} {-hip_y} 0"`) and needs no code beside it. Text
in braces is parsed and only numbers, names, + - * / **, sqrt, abs, min, max, sin and cos (of
radians) are evaluated.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Collection, Mapping
from importlib.resources import files
from typing import Any

PLACEHOLDER = re.compile(r"\{([^{}]+)\}")
_ARITHMETIC = re.compile(r"[\w\s.+\-*/(),]+")
"""What may stand in braces: nothing that XML would take for markup or Python for a comment."""

_BINARY: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
FUNCTIONS: dict[str, Callable[..., float]] = {
    "sqrt": math.sqrt,
    "abs": abs,
    "min": min,
    "max": max,
    "sin": math.sin,
    "cos": math.cos,
}


def read_asset(name: str) -> str:
    """Return the text of `assets/<name>`."""
    return (files("robomore.tasks") / "assets" / name).read_text(encoding="utf-8")


def fill(template: str, values: Mapping[str, float], keep: Collection[str] = ()) -> str:
    """Return `template` with each placeholder replaced by its number.

    Args:
        template: text with `{expression}` placeholders.
        values: numbers by name.
        keep: names whose placeholders stay as they are (a masked template).

    Raises:
        KeyError: a placeholder uses a name that `values` lacks.
        ValueError: a placeholder is not plain arithmetic.
    """

    def replace(match: re.Match[str]) -> str:
        tree = parse(match[1])
        if any(isinstance(node, ast.Name) and node.id in keep for node in ast.walk(tree)):
            return match[0]
        # repr keeps every digit, so the same parameters always give the same text.
        return repr(float(evaluate(tree, values)))

    return PLACEHOLDER.sub(replace, template)


def names_used(template: str) -> set[str]:
    """Return the names that the placeholders of `template` refer to."""
    trees = (parse(text) for text in PLACEHOLDER.findall(template))
    names = {node.id for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Name)}
    return names - set(FUNCTIONS)


def parse(expression: str) -> ast.expr:
    """Return the syntax tree of what stands in braces.

    Raises:
        ValueError: it is no expression.
    """
    try:
        if not _ARITHMETIC.fullmatch(expression):
            raise SyntaxError
        return ast.parse(expression.strip(), mode="eval").body
    except (SyntaxError, MemoryError, RecursionError):
        raise ValueError(f"{{{expression[:80]}}} in a template is no arithmetic") from None


def check_arithmetic(node: ast.expr) -> None:
    """Refuse an expression that is not plain arithmetic over names.

    Raises:
        ValueError: it is not.
    """
    match node:
        case ast.Constant(value=int() | float()) | ast.Name():
            return
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return check_arithmetic(operand)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
            check_arithmetic(left)
            return check_arithmetic(right)
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
            for argument in args:
                check_arithmetic(argument)
            return
    raise ValueError(f"not plain arithmetic in a template: {ast.unparse(node)}")


def evaluate(
    node: ast.expr,
    values: Mapping[str, Any],
    functions: Mapping[str, Callable[..., Any]] = FUNCTIONS,
) -> Any:
    """Return the number that a placeholder stands for.

    Args:
        node: what `parse` returned.
        values: numbers by name, or arrays of numbers, element by element.
        functions: those of `FUNCTIONS`, for what the values are.

    Raises:
        KeyError: it uses a name that `values` lacks.
        ValueError: it is not plain arithmetic.
    """

    def of(inner: ast.expr) -> Any:
        return evaluate(inner, values, functions)

    match node:
        case ast.Constant(value=int() | float() as number):
            return float(number)
        case ast.Name(id=name):
            return values[name]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -of(operand)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
            return _BINARY[type(op)](of(left), of(right))
        case ast.Call(func=ast.Name(id=name), args=args) if name in functions:
            return functions[name](*map(of, args))
    raise ValueError(f"not plain arithmetic in a template: {ast.unparse(node)}")
