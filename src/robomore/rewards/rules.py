"""What each statement and expression of a reward may do: the rules of `check_reward`."""

from __future__ import annotations

import ast
import dis
import warnings
from collections.abc import Callable, Iterator
from types import CodeType

from robomore.envs.reward_modules import DRAW, MODULES, STANDARD
from robomore.rewards.finding import Finding
from robomore.rewards.paths import path_of

_INSTEAD = {
    "random": "draw from `self.np_random`",
    "time": "`self.data.time` is the time in the episode, in s",
    "datetime": "`self.data.time` is the time in the episode, in s",
    "types": "only `from types import SimpleNamespace` is possible",
}


def _imports(node: ast.AST) -> Iterator[Finding]:
    match node:
        case ast.Import(names=names):
            imported = [alias.name for alias in names]
        case ast.ImportFrom(module="types", names=[ast.alias(name="SimpleNamespace")]):
            return
        case ast.ImportFrom(module=module, level=level, names=names):
            imported = ["." * level + (module or "")]
            if any(alias.name == "*" for alias in names):
                yield Finding(node.lineno, "error", "name what you import in the place of `*`")
            if module == "numpy" and "random" in (alias.name for alias in names):
                yield Finding(node.lineno, "error", f"cannot import `random`; {DRAW}")
        case _:
            return
    for name in imported:
        if name not in MODULES:
            instead = _INSTEAD.get(
                name.partition(".")[0],
                f"a reward has numpy and, of the standard library, {', '.join(STANDARD)}",
            )
            yield Finding(node.lineno, "error", f"cannot import `{name}`; {instead}")


_CALLS = {
    **dict.fromkeys(("open", "input"), "a reward can read and write no files"),
    **dict.fromkeys(("exec", "eval", "compile"), "write the code out instead of building it"),
    **dict.fromkeys(
        ("id", "hash"), "it differs from one process to the next; use a number of your own"
    ),
    "__import__": "write an import statement",
    "breakpoint": "nobody is there to debug with",
    **dict.fromkeys(
        ("globals", "locals", "vars", "setattr", "delattr", "exit", "quit", "memoryview"),
        "compute from self, x_velocity and action alone",
    ),
}


_LOOKUPS = ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_CLASSDEREF", "LOAD_FROM_DICT_OR_GLOBALS")
"""Instructions that come to the builtins where nothing nearer has the name."""

_PLAIN_DUNDERS = frozenset({"__name__", "__debug__", "__slots__", "__init__", "__post_init__"})
"""Names with underscores that a class of one's own needs."""


def _names(node: ast.AST) -> Iterator[Finding]:
    match node:
        case ast.Name(id=name) if _dunder(name) and name not in _PLAIN_DUNDERS:
            yield Finding(node.lineno, "error", f"`{name}` is not for rewards")
        case ast.Call(func=ast.Name(id="print")):
            yield Finding(node.lineno, "warning", "`print` does nothing here; put it in the terms")
        case ast.Call(args=arguments) if any(
            isinstance(one, ast.Name) and one.id == "getattr" for one in arguments
        ):
            yield Finding(node.lineno, "error", "call `getattr` yourself, with a name in quotes")
        case ast.Assign(value=ast.Name(id="getattr")) | ast.NamedExpr(value=ast.Name(id="getattr")):
            yield Finding(node.lineno, "error", "call `getattr` itself, not another name of it")
        case ast.Call(
            func=ast.Name(id="attrgetter" | "methodcaller" as name)
            | ast.Attribute(attr="attrgetter" | "methodcaller" as name),
            args=arguments,
        ):
            read = arguments if name == "attrgetter" else arguments[:1]
            if not all(
                isinstance(one, ast.Constant) and "_" not in (it[:1] for it in _parts(one.value))
                for one in read
            ):
                yield Finding(
                    node.lineno, "error", f"give `{name}` a public name of an attribute, in quotes"
                )
        case ast.MatchClass(kwd_attrs=names) if any(map(_dunder, names)):
            yield Finding(node.lineno, "error", "a pattern cannot read names with underscores")
        case ast.Call(func=ast.Name(id="getattr" | "hasattr"), args=[first, second, *_]):
            plain = isinstance(second, ast.Constant) and isinstance(second.value, str)
            name = str(getattr(second, "value", ""))
            if not plain or name.startswith("__"):
                yield Finding(node.lineno, "error", "name the attribute that is read: `self.name`")
            elif isinstance(first, ast.Name) and first.id == "self" and name in _ABSENT:
                yield Finding(node.lineno, "error", _ABSENT[name])


_ABSENT = {
    "training_progress": "there is no `self.training_progress`, because a training can be "
    "continued with more steps; `self.training_steps` counts the control steps done so far",
    "spec": "`self.spec` is None in training; write out the number of control steps of an episode",
}
"""Attributes that designers expect of `self`, and what to read instead."""


def _attributes(node: ast.AST) -> Iterator[Finding]:
    if not isinstance(node, ast.Attribute):
        return
    name = node.attr
    if name in _FRAMES or (_dunder(name) and name not in _PLAIN_DUNDERS):
        yield Finding(node.lineno, "error", f"`.{name}` is not for rewards")
    if name in ("tofile", "dump"):
        yield Finding(node.lineno, "error", f"`.{name}` writes a file; a reward cannot")
    if name == "setflags":
        yield Finding(node.lineno, "error", "`.setflags` is not for rewards; change a copy")
    if name == "ctypes":
        yield Finding(node.lineno, "error", "`.ctypes` gives addresses, which are never the same")
    read = isinstance(node.ctx, ast.Load)
    if read and name in _ABSENT and path_of(node) == ["self", name]:
        yield Finding(node.lineno, "error", _ABSENT[name])
    if name in ("_inst", "_name") and not read and path_of(node)[:1] != ["self"]:
        said = f"`.{name}` of a type from `typing` belongs to everybody; choose another name"
        yield Finding(node.lineno, "error", said)
    if name == "bit_generator":
        yield Finding(node.lineno, "error", "`.bit_generator` is not for rewards; draw from it")


_FRAMES = frozenset(
    (
        *("f_globals", "f_locals", "f_builtins", "f_back", "f_code", "tb_frame", "tb_next"),
        *("gi_frame", "gi_code", "cr_frame", "cr_code", "ag_frame", "ag_code", "co_code"),
    )
)

_WAYS_OUT = (ast.Break, ast.Return, ast.Raise, ast.Yield)


def _statements(node: ast.AST) -> Iterator[Finding]:
    match node:
        case ast.Global(names=names) | ast.Nonlocal(names=names):
            yield Finding(node.lineno, "note", kept_for_training(f"`{', '.join(names)}`"))
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
            path = path_of(part)
            if not path and isinstance(part, ast.Attribute):
                yield Finding(node.lineno, "error", f"changes `{ast.unparse(part)}`")
            if path[:2] in (["self", "data"], ["self", "model"], ["self", "unwrapped"]):
                yield Finding(
                    node.lineno,
                    "error",
                    f"writes to `{'.'.join(path[:2])}`; a reward reads the physics and leaves it",
                )


RULES: tuple[Callable[[ast.AST], Iterator[Finding]], ...] = (
    _imports,
    _names,
    _attributes,
    _statements,
    _writes,
)
"""Each is given one node of the syntax tree."""


def builtins_used(tree: ast.Module) -> Iterator[Finding]:
    """Find each use of a builtin that is not for rewards.

    A function's own `id` or `input` is none. The compiler tells them apart: what a function binds
    itself, as an argument for example, it never looks up among the builtins.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            waiting = [compile(tree, "<reward>", "exec", dont_inherit=True, optimize=0)]
    except SyntaxError as error:  # what parses need not compile
        yield Finding(error.lineno or 1, "error", error.msg)
        return
    except (ValueError, RecursionError, MemoryError) as error:
        yield Finding(1, "error", str(error) or "it is nested too deeply")
        return
    while waiting:
        code = waiting.pop()
        waiting += [inner for inner in code.co_consts if isinstance(inner, CodeType)]
        for step in dis.get_instructions(code):
            name, line = step.argval, step.positions and step.positions.lineno
            if step.opname in _LOOKUPS and name in _CALLS:
                yield Finding(line or 1, "error", f"`{name}` is not for rewards: {_CALLS[name]}")


def changed_imports(tree: ast.Module) -> Iterator[Finding]:
    """Find each place where something imported, or a class of another's, is given an attribute.

    Under another name, too: after `cls = type(self)` or `norm = np.linalg.norm`.
    """
    imported = {"np", "numpy", "math"}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            imported |= {(it.asname or it.name).partition(".")[0] for it in node.names}
    named_after: dict[str, set[str]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign | ast.NamedExpr):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            of_type = isinstance(node.value, ast.Call) and path_of(node.value.func) == ["type"]
            root = "type" if of_type else (path_of(node.value) or [""])[0]
            names = {target.id for target in targets if isinstance(target, ast.Name)}
            named_after.setdefault(root, set()).update(names)
    waiting = [*imported, "type"]
    while waiting:  # a name of a name of a name
        new = named_after.pop(waiting.pop(), set()) - imported
        imported |= new
        waiting += new
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute | ast.Subscript) and not isinstance(node.ctx, ast.Load):
            path = path_of(node)
            if path and path[0] in imported:
                yield Finding(node.lineno, "error", f"changes `{'.'.join(path[:2])}` for everybody")


def kept_for_training(what: str) -> str:
    """Return the message about what a reward keeps elsewhere than in `self`."""
    return (
        f"keeps {what} for the whole training, one in each simulation; what should start anew with "
        "each episode belongs in an attribute of `self`"
    )


_NO_TIME = 1e-6
"""Far less than any control step takes, in s."""


def never_at_the_start(function: ast.AST) -> Iterator[Finding]:
    """Note each question whether the time in an episode is 0: it never is when a reward is called.

    Args:
        function: the definition of `_get_rew`.
    """
    given: dict[str, list[bool]] = {}
    for node in ast.walk(function):
        if isinstance(node, ast.Assign | ast.AugAssign | ast.AnnAssign | ast.For | ast.NamedExpr):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            value = None if isinstance(node, ast.For | ast.AugAssign) else node.value
            for one in (inner for target in targets for inner in ast.walk(target)):
                if isinstance(one, ast.Name):
                    given.setdefault(one.id, []).append(_is_time(value))
    names = {name for name, times in given.items() if all(times)}

    def time(node: ast.AST) -> bool:
        return _is_time(node) or (isinstance(node, ast.Name) and node.id in names)

    for node in ast.walk(function):
        match node:
            case ast.Compare(left=left, ops=[ast.Eq() | ast.LtE() | ast.Lt()], comparators=[right]):
                never = time(left) and _is_nothing(right)
                never |= isinstance(node.ops[0], ast.Eq) and time(right) and _is_nothing(left)
            case ast.Compare(left=left, ops=[ast.GtE() | ast.Gt()], comparators=[right]):
                never = time(right) and _is_nothing(left)
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                never = time(operand)
            case _:
                continue
        if never:
            yield Finding(
                node.lineno,
                "note",
                "`self.data.time` is never 0 here, since a reward is called after each control "
                "step: what asks for that here never holds; attributes of `self` start anew with "
                "each episode by themselves",
            )


def _is_time(node: ast.AST | None) -> bool:
    match node:
        case ast.Call(func=ast.Name(id="float"), args=[inner]):
            return _is_time(inner)
        case ast.Attribute():
            return path_of(node) == ["self", "data", "time"]
    return False


def _is_nothing(node: ast.AST) -> bool:
    match node:
        case ast.Constant(value=bool()):
            return False
        case ast.Constant(value=int() | float() as value):
            return 0 <= value <= _NO_TIME
    return False


def kept_attributes(function: ast.AST) -> Iterator[Finding]:
    """Note each attribute of the robot that `_get_rew` sets, once.

    Args:
        function: the definition of `_get_rew`; only there is `self` the robot.
    """
    seen = set()
    for node in ast.walk(function):
        if not isinstance(node, ast.Attribute) or not isinstance(node.ctx, ast.Store):
            continue
        path = path_of(node)
        if path[:1] == ["self"] and path[1:2] not in (["data"], ["model"]) and path[1] not in seen:
            seen.add(path[1])
            yield Finding(
                node.lineno,
                "note",
                f"keeps `self.{path[1]}` between the steps of an episode; it is gone when the next "
                "one begins (`self.training_steps` counts over the whole training)",
            )


def _dunder(name: str) -> bool:
    return name.startswith("__") and name.endswith("__")


def _parts(name: object) -> list[str]:
    return str(name).split(".")
