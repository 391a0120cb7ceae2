"""Reads the text of a reward and says what is wrong with it, in words that a designer can act on.

This is no protection: it saves a training that must fail, and it turns honest mistakes into advice.
Whoever wants to get past it can. The sandbox (`robomore.sandbox`) is what protects the machine.
"""

from __future__ import annotations

import ast
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

NAME = "_get_rew"
LONGEST = 50_000
"""Characters that a reward may have; the parser is not to be trusted with any length."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong, or probably wrong.

    Attributes:
        line: of the text, counted from 1.
        severity: an `error` keeps the reward from being trained, a `warning` does not.
        message: what is wrong and what to do instead.
    """

    line: int
    severity: Literal["error", "warning"]
    message: str


def check_reward(source: str) -> list[Finding]:
    """Return what is wrong with the text of a reward, in the order of its lines.

    The text is parsed and never executed.

    Args:
        source: program text that should define `_get_rew(self, x_velocity, action)`.
    """
    if len(source) > LONGEST:
        said = f"{len(source):,} characters are too many for a reward; the most is {LONGEST:,}"
        return [Finding(1, "error", said)]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of odd escapes, which are no business of the user's
            tree = ast.parse(source)
    except SyntaxError as error:
        return [Finding(error.lineno or 1, "error", f"does not parse: {error.msg}")]
    except (ValueError, RecursionError, MemoryError) as error:
        said = str(error) or "it is nested too deeply"
        return [Finding(1, "error", f"does not parse: {said}")]
    found = set(_check_function(tree))
    for node in ast.walk(tree):
        for rule in _RULES:
            found.update(rule(node))
    return sorted(found, key=lambda finding: (finding.line, finding.severity, finding.message))


def _check_function(tree: ast.Module) -> Iterator[Finding]:
    """Check that there is one `_get_rew`, that it can be called, and that it returns a pair."""
    defined = [
        node
        for node in tree.body
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.name == NAME
    ]
    if not defined:
        inner = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef) and n.name == NAME]
        line = inner[0].lineno if inner else 1
        where = ", and not inside a class or another function" if inner else ""
        yield Finding(
            line, "error", f"define `def {NAME}(self, x_velocity, action):` at the top level{where}"
        )
        return
    for again in defined[1:]:
        yield Finding(again.lineno, "error", f"`{NAME}` is defined twice; keep one")
    function = defined[-1]
    if isinstance(function, ast.AsyncFunctionDef):
        yield Finding(function.lineno, "error", f"`{NAME}` must be a plain function, not `async`")
    for decorator in function.decorator_list:
        yield Finding(decorator.lineno, "error", f"`{NAME}` must not be decorated")
    yield from _check_signature(function)
    yield from _check_returns(function)


def _check_signature(function: ast.FunctionDef | ast.AsyncFunctionDef) -> Iterator[Finding]:
    given = function.args
    names = [argument.arg for argument in (*given.posonlyargs, *given.args)]
    required = len(names) - len(given.defaults)
    demanded = any(default is None for default in given.kw_defaults)
    fits = required <= 3 <= len(names) or (given.vararg is not None and required <= 3)
    if not fits or demanded:
        said = ", ".join(names)
        yield Finding(
            function.lineno, "error", f"`{NAME}` must take (self, x_velocity, action), not ({said})"
        )


def _check_returns(function: ast.FunctionDef | ast.AsyncFunctionDef) -> Iterator[Finding]:
    own = list(_own_statements(function))
    if any(isinstance(node, ast.Yield | ast.YieldFrom) for node in own):
        yield Finding(function.lineno, "error", f"`{NAME}` must return, not yield")
        return
    returns = [node for node in own if isinstance(node, ast.Return)]
    if not returns:
        yield Finding(
            function.lineno,
            "error",
            f"`{NAME}` returns nothing; end it with `return reward, terms`, a number and a "
            "dictionary of its terms",
        )
    for node in returns:
        if _cannot_be_a_pair(node.value):
            yield Finding(
                node.lineno,
                "error",
                "return a pair: the reward as a number, and a dictionary of its terms",
            )


def _cannot_be_a_pair(value: ast.expr | None) -> bool:
    match value:
        case None | ast.Constant() | ast.Dict() | ast.Set() | ast.BinOp() | ast.UnaryOp():
            return True
        case ast.JoinedStr() | ast.Lambda() | ast.Compare() | ast.DictComp() | ast.SetComp():
            return True
        case ast.Call(func=ast.Name(id="float" | "int" | "abs" | "sum" | "dict" | "str")):
            return True
        case ast.Tuple(elts=elements) | ast.List(elts=elements):
            return len(elements) != 2 and not any(isinstance(e, ast.Starred) for e in elements)
    return False


def _own_statements(function: ast.AST) -> Iterator[ast.AST]:
    """Walk a function's nodes but not those of functions and classes defined in it."""
    waiting = list(ast.iter_child_nodes(function))
    while waiting:
        node = waiting.pop()
        yield node
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda | ast.ClassDef):
            waiting.extend(ast.iter_child_nodes(node))


_MODULES = frozenset({"numpy", "math", "typing", "__future__", "collections.abc"})
_NUMPY_MODULES = frozenset({"numpy.linalg", "numpy.fft", "numpy.typing", "numpy.polynomial"})


def _imports(node: ast.AST) -> Iterator[Finding]:
    match node:
        case ast.Import(names=names):
            imported = [alias.name for alias in names]
        case ast.ImportFrom(module=module, level=level):
            imported = ["." * level + (module or "")]
        case _:
            return
    for name in imported:
        if name not in _MODULES | _NUMPY_MODULES:
            yield Finding(
                node.lineno, "error", f"cannot import `{name}`; a reward has numpy and math only"
            )


_CALLS = {
    **dict.fromkeys(("open", "input"), "a reward can read and write no files"),
    **dict.fromkeys(("exec", "eval", "compile"), "write the code out instead of building it"),
    "__import__": "a reward has numpy and math only",
    "breakpoint": "nobody is there to debug with",
    **dict.fromkeys(
        ("globals", "locals", "vars", "setattr", "delattr", "exit", "quit", "memoryview"),
        "compute from self, x_velocity and action alone",
    ),
}


def _names(node: ast.AST) -> Iterator[Finding]:
    match node:
        case ast.Name(id=name) if name in _CALLS:
            yield Finding(node.lineno, "error", f"`{name}` is not for rewards: {_CALLS[name]}")
        case ast.Name(id=name) if _dunder(name) and name not in ("__name__", "__debug__"):
            yield Finding(node.lineno, "error", f"`{name}` is not for rewards")
        case ast.Call(func=ast.Name(id="print")):
            yield Finding(node.lineno, "warning", "`print` does nothing here; put it in the terms")
        case ast.Call(func=ast.Name(id="getattr" | "hasattr"), args=[_, second, *_]):
            plain = isinstance(second, ast.Constant) and isinstance(second.value, str)
            if not plain or str(getattr(second, "value", "")).startswith("__"):
                yield Finding(node.lineno, "error", "name the attribute that is read: `self.name`")


def _attributes(node: ast.AST) -> Iterator[Finding]:
    if not isinstance(node, ast.Attribute):
        return
    if _dunder(node.attr) or node.attr in _FRAMES:
        yield Finding(node.lineno, "error", f"`.{node.attr}` is not for rewards")
    if node.attr in ("tofile", "dump"):
        yield Finding(node.lineno, "error", f"`.{node.attr}` writes a file; a reward cannot")
    root = _root(node)
    if root in ("np", "numpy") and node.attr in _NUMPY_DOORS:
        yield Finding(
            node.lineno,
            "error",
            f"`{root}.{node.attr}` reaches outside; a reward computes from numbers alone",
        )
    if root in ("np", "numpy") and node.attr == "random":
        yield Finding(
            node.lineno,
            "warning",
            "a random reward makes training noisy and cannot be repeated; leave chance out",
        )


_FRAMES = frozenset(
    (
        *("f_globals", "f_locals", "f_builtins", "f_back", "f_code", "tb_frame", "tb_next"),
        *("gi_frame", "gi_code", "cr_frame", "cr_code", "ag_frame", "ag_code", "co_code"),
    )
)
_NUMPY_DOORS = frozenset(
    (
        *("load", "save", "savez", "savez_compressed", "loadtxt", "savetxt", "genfromtxt"),
        *("fromregex", "fromfile", "tofile", "memmap", "open_memmap", "DataSource", "ctypeslib"),
        *("f2py", "distutils", "lib", "core", "_core", "testing", "get_include", "show_config"),
    )
)


_WAYS_OUT = (ast.Break, ast.Return, ast.Raise, ast.Yield)


def _statements(node: ast.AST) -> Iterator[Finding]:
    match node:
        case ast.Global() | ast.Nonlocal():
            kind = "global" if isinstance(node, ast.Global) else "nonlocal"
            yield Finding(
                node.lineno,
                "error",
                f"`{kind}` keeps a memory between calls, which several simulations would share; "
                "compute from self, x_velocity and action alone",
            )
        case ast.While(test=ast.Constant(value=value)) if value and not any(
            isinstance(inner, _WAYS_OUT) for inner in ast.walk(node)
        ):
            yield Finding(node.lineno, "error", "this loop never ends")
        case ast.AsyncFunctionDef() | ast.Await() | ast.AsyncFor() | ast.AsyncWith():
            yield Finding(node.lineno, "error", "a reward is plain code, without async")


def _writes(node: ast.AST) -> Iterator[Finding]:
    targets: list[ast.expr]
    match node:
        case ast.Assign() | ast.Delete():
            targets = node.targets
        case ast.AugAssign() | ast.AnnAssign():
            targets = [node.target]
        case _:
            return
    for target in targets:
        for part in ast.walk(target):
            if not isinstance(part, ast.Attribute | ast.Subscript):
                continue
            if not isinstance(part.ctx, ast.Store | ast.Del):
                continue
            path = _path(part)
            if not path and isinstance(part, ast.Attribute):
                yield Finding(node.lineno, "error", f"changes `{ast.unparse(part)}`")
            if path[:2] in (["self", "data"], ["self", "model"], ["self", "unwrapped"]):
                yield Finding(
                    node.lineno,
                    "error",
                    f"writes to `{'.'.join(path[:2])}`; a reward reads the physics and leaves it",
                )
            elif path[:1] == ["self"]:
                yield Finding(
                    node.lineno,
                    "warning",
                    f"keeps `{'.'.join(path[:2])}` between calls; it starts anew with each episode "
                    "only if you see to it",
                )
            elif path[:1] in (["np"], ["numpy"], ["math"]):
                yield Finding(node.lineno, "error", f"changes `{'.'.join(path[:2])}` for everybody")


_RULES: tuple[Callable[[ast.AST], Iterator[Finding]], ...] = (
    _imports,
    _names,
    _attributes,
    _statements,
    _writes,
)


def _dunder(name: str) -> bool:
    return name.startswith("__") and name.endswith("__")


def _path(node: ast.expr) -> list[str]:
    """Return `["self", "data", "qpos"]` for `self.data.qpos[2:]`, empty for anything else."""
    names: list[str] = []
    rest = node
    while isinstance(rest, ast.Attribute | ast.Subscript):
        if isinstance(rest, ast.Attribute):
            names.append(rest.attr)
        rest = rest.value
    return [rest.id, *reversed(names)] if isinstance(rest, ast.Name) else []


def _root(node: ast.expr) -> str:
    return (_path(node) or [""])[0]
