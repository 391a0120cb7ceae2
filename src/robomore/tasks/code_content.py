"""What a function of a task consists of, as plain data that is the same in every process.

The text of a function does not say all: it calls helpers, reads constants of its module, and holds
values in its closure and defaults. All of these are followed within the function's own package and
within RoboMoRe. Other packages are known by their versions, which every run records.
"""

from __future__ import annotations

import ast
import dataclasses
import functools
import linecache
import math
import sys
from collections.abc import Iterator, Mapping
from types import CodeType, FunctionType, MethodType, ModuleType
from typing import Any

_DIGITS = 9
"""Significant digits of a computed number: the last ones depend on the machine's libraries."""


def content(value: Any, *, computed: bool = False) -> Any:
    """Return `value` as nested lists and texts, without addresses and file paths.

    Args:
        value: a function, a number, a container of them, or any object.
        computed: whether it is the result of a calculation: numbers are rounded, and classes are
            told by their names alone.
    """
    return _Content(getattr(value, "__module__", None) or "", computed).of(value)


class _Content:
    """Describes values; objects of other packages than `module`'s by their names alone."""

    def __init__(self, module: str, computed: bool) -> None:
        self._own = {"robomore", module.partition(".")[0]} - sys.stdlib_module_names
        self._computed = computed
        self._open: set[int] = set()  # what is being described: functions may call each other

    def of(self, value: Any) -> Any:
        if value is None or isinstance(value, bool | int | str | bytes):
            return [type(value).__name__, repr(value)]
        if isinstance(value, float):
            return ["float", f"{value:.{_DIGITS}g}" if self._computed else repr(float(value))]
        if isinstance(value, ModuleType):
            return ["module", value.__name__]
        if id(value) in self._open:
            return ["again", getattr(value, "__qualname__", type(value).__qualname__)]
        self._open.add(id(value))
        try:
            return self._of_object(value)
        finally:
            self._open.discard(id(value))

    def _of_object(self, value: Any) -> Any:
        match value:
            case FunctionType():
                return self._of_function(value)
            case MethodType():
                return ["method", self.of(value.__func__), self.of(value.__self__)]
            case functools.partial():
                return ["partial", *map(self.of, (value.func, value.args, value.keywords))]
            case type():
                return self._of_class(value)
            case tuple() | list():
                return [type(value).__name__, *map(self.of, value)]
            case set() | frozenset():
                return ["set", *sorted(map(self.of, value), key=repr)]
            case Mapping():
                return ["mapping", *([self.of(k), self.of(v)] for k, v in value.items())]
        if hasattr(value, "tolist") and hasattr(value, "dtype"):
            return ["array", str(value.dtype), self.of(value.tolist())]
        fields: dict[str, Any] = {}
        if dataclasses.is_dataclass(value):
            fields = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
        elif self._is_own(type(value)) or isinstance(value, functools._lru_cache_wrapper):
            fields = dict(getattr(value, "__dict__", {}))
        name = getattr(value, "__qualname__", None) or getattr(value, "__name__", "")
        return ["object", self.of(type(value)), str(name), self.of(fields)]

    def _of_class(self, value: type) -> Any:
        name = f"{value.__module__}.{value.__qualname__}"
        module = sys.modules.get(value.__module__)
        filename = getattr(module, "__file__", None)
        if self._computed or not self._is_own(value) or filename is None:
            return ["class", name]
        functions = [one for one in map(_function_of, vars(value).values()) if one is not None]
        text = _class_texts(filename).get(value.__qualname__, "")
        # What `dataclass` and its like write has no text: it follows from the class's own.
        written = [one for one in functions if one.__code__.co_filename == filename]
        return ["class", name, text, [self._references(one) for one in written]]

    def _of_function(self, function: FunctionType) -> Any:
        text = _text(function.__code__)
        return [
            "function",
            self._of_code(function.__code__) if text is None else text,
            self.of(function.__defaults__),
            self.of(function.__kwdefaults__),
            self._closure(function),
            self._references(function),
        ]

    def _of_code(self, code: CodeType) -> Any:
        constants = [
            self._of_code(one) if isinstance(one, CodeType) else self.of(one)
            for one in code.co_consts
        ]
        names = [list(code.co_names), list(code.co_varnames), list(code.co_freevars)]
        return ["code", code.co_code.hex(), constants, names]

    def _closure(self, function: FunctionType) -> Any:
        cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
        found = []
        for name, cell in cells:
            try:
                held = cell.cell_contents
            except ValueError:
                continue  # not yet filled: a function that is being defined
            found.append([name, self.of(held)])
        return found

    def _references(self, function: FunctionType) -> Any:
        """Return what the names that a function reads from its module stand for."""
        names = sorted(set(_names(function.__code__)))
        found = {}
        for name in names:
            if name not in function.__globals__:
                continue  # a builtin, or the name of an attribute
            value = found[name] = function.__globals__[name]
            if isinstance(value, ModuleType) and self._is_own(value):
                found |= {f"{name}.{one}": vars(value)[one] for one in names if one in vars(value)}
        return [
            [name, ["outside", value.__module__, value.__qualname__]]
            if isinstance(value, FunctionType) and not self._is_own(value)
            else [name, self.of(value)]
            for name, value in found.items()
        ]

    def _is_own(self, value: Any) -> bool:
        name = value.__name__ if isinstance(value, ModuleType) else value.__module__
        return str(name).partition(".")[0] in self._own


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _function_of(member: Any) -> FunctionType | None:
    """Return the function behind a class's member, if there is one."""
    inner = getattr(member, "fget", None) or getattr(member, "__func__", None) or member
    return inner if isinstance(inner, FunctionType) else None


def _text(code: CodeType) -> str | None:
    """Return the text of one function or lambda, or `None` where there is none.

    A lambda's text is the lambda alone, whatever else stands in its line.
    """
    defined = _function_texts(code.co_filename).get(code.co_firstlineno, [])
    if code.co_name == "<lambda>":
        starts = {column for _, _, column, _ in code.co_positions() if column}
        inside = [
            text
            for name, text, first, last in defined
            if name == "<lambda>" and all(first <= column <= last for column in starts)
        ]
        return min(inside, key=len, default=None)
    return next((text for name, text, _, _ in defined if name == code.co_name), None)


@functools.lru_cache(maxsize=256)
def _tree(filename: str) -> tuple[list[bytes], ast.Module]:
    """Return lines (columns of a tree count bytes) and syntax tree of a file, empty without one."""
    lines = linecache.getlines(filename)
    try:
        return [line.encode() for line in lines], ast.parse("".join(lines))
    except SyntaxError:
        return [], ast.Module([], [])


@functools.lru_cache(maxsize=256)
def _function_texts(filename: str) -> dict[int, list[tuple[str, str, int, float]]]:
    """Return by first line: name, text, first and last column of each function of a file."""
    lines, tree = _tree(filename)
    found: dict[int, list[tuple[str, str, int, float]]] = {}
    for node in ast.walk(tree):
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        name, first, columns = "<lambda>", node.lineno, (0, math.inf)
        if not isinstance(node, ast.Lambda):
            name, first = node.name, min([first, *(one.lineno for one in node.decorator_list)])
        elif node.end_lineno == node.lineno:
            columns = node.col_offset, node.end_col_offset or math.inf
        found.setdefault(first, []).append((name, _segment(lines, node), *columns))
    return found


@functools.lru_cache(maxsize=256)
def _class_texts(filename: str) -> dict[str, str]:
    """Return the text of each class of a file, by qualified name."""
    lines, tree = _tree(filename)
    found: dict[str, str] = {}
    waiting: list[tuple[str, ast.AST]] = [("", tree)]
    while waiting:
        prefix, outer = waiting.pop()
        for node in ast.iter_child_nodes(outer):
            if isinstance(node, ast.ClassDef):
                found[prefix + node.name] = _segment(lines, node)
                waiting.append((f"{prefix}{node.name}.", node))
    return found


def _segment(lines: list[bytes], node: ast.stmt | ast.expr) -> str:
    last = node.end_lineno or node.lineno
    chosen = lines[node.lineno - 1 : last]
    chosen[-1] = chosen[-1][: node.end_col_offset]
    chosen[0] = chosen[0][node.col_offset :]
    return b"".join(chosen).decode()
