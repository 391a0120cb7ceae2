"""Reads the text of a reward and says what is wrong with it, in words that a designer can act on.

This is no protection: it saves a training that must fail, and it turns honest mistakes into advice.
Whoever wants to get past it can. The sandbox (`robomore.sandbox`) is what protects the machine.
"""

from __future__ import annotations

import ast
import warnings
from collections.abc import Iterator

from robomore.rewards.characters import check_characters
from robomore.rewards.finding import Finding
from robomore.rewards.module_rules import module_uses
from robomore.rewards.rules import (
    RULES,
    builtins_used,
    changed_imports,
    kept_attributes,
    never_at_the_start,
)

__all__ = ["LONGEST", "NAME", "Finding", "check_reward", "why_unparsed"]

NAME = "_get_rew"
LONGEST = 50_000
"""Characters that a reward may have; the parser is not to be trusted with any length."""


def check_reward(source: str) -> list[Finding]:
    """Return what is wrong with the text of a reward, in the order of its lines.

    The text is compiled and never executed.

    Args:
        source: program text that should define `_get_rew(self, x_velocity, action)`.
    """
    if len(source) > LONGEST:
        said = f"{len(source):,} characters are too many for a reward; the most is {LONGEST:,}"
        return [Finding(1, "error", said)]
    if found := list(check_characters(source)):
        return found
    source = source.removeprefix("\ufeff")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of odd escapes, which are no business of the user's
            tree = ast.parse(source)
    except SyntaxError as error:
        said = f"does not parse: {why_unparsed(source, error)}"
        return [Finding(error.lineno or 1, "error", said)]
    except (ValueError, RecursionError, MemoryError) as error:
        said = str(error) or "it is nested too deeply"
        return [Finding(1, "error", f"does not parse: {said}")]
    findings = {*_check_function(tree), *changed_imports(tree), *module_uses(tree)}
    findings.update(builtins_used(tree))
    for node in ast.walk(tree):
        for rule in RULES:
            findings.update(rule(node))
    return sorted(findings, key=lambda finding: (finding.line, finding.severity, finding.message))


def why_unparsed(source: str, error: SyntaxError) -> str:
    """Return in words why a text is no Python."""
    if source.lstrip().startswith("```"):
        return "leave out the lines of ``` around the code"
    return error.msg


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
        said = f"define `def {NAME}(self, x_velocity, action):` at the top level{where}"
        if not inner and (meant := _meant(tree)):
            line, said = meant.lineno, f"rename `{meant.name}` to `{NAME}`, which training calls"
            said += "" if _can_be_called(meant) else " with (self, x_velocity, action)"
        yield Finding(line, "error", said)
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
    yield from kept_attributes(function)
    yield from never_at_the_start(function)


def _meant(tree: ast.Module) -> ast.FunctionDef | None:
    """Return the function that is the reward under another name, if it is plain which one is.

    That is the only one that takes three arguments, or the only one of these that speaks of
    rewards in its name, or the only function of all.
    """
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    fitting = [node for node in functions if _can_be_called(node)]
    called = [node for node in fitting if "rew" in node.name.lower()]
    return next((one[0] for one in (fitting, called, functions) if len(one) == 1), None)


def _can_be_called(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Whether a function can be given (self, x_velocity, action)."""
    given = function.args
    most = len(given.posonlyargs) + len(given.args)
    required = most - len(given.defaults)
    if any(default is None for default in given.kw_defaults):
        return False
    return required <= 3 and (most >= 3 or given.vararg is not None)


def _check_signature(function: ast.FunctionDef | ast.AsyncFunctionDef) -> Iterator[Finding]:
    names = [argument.arg for argument in (*function.args.posonlyargs, *function.args.args)]
    if not _can_be_called(function):
        said = ", ".join(names)
        yield Finding(
            function.lineno, "error", f"`{NAME}` must take (self, x_velocity, action), not ({said})"
        )
    elif names[1:3] == ["action", "x_velocity"]:
        yield Finding(
            function.lineno,
            "error",
            f"`{NAME}` is given (self, x_velocity, action) in this order; exchange the two names",
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
