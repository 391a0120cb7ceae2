"""Parses a reply into a morphology or a reward, or into the errors that go back to the model."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Sequence
from typing import Any

from robomore.designers.llm.code_extraction import find_code, parsed
from robomore.designers.llm.extraction import NotFound, Unreadable, find_object
from robomore.designers.llm.quantities import NoNumber, read_parameters
from robomore.errors import InvalidMorphology
from robomore.rewards.check import NAME, Finding, check_reward
from robomore.tasks.task import Task
from robomore.types import Morphology, Reward

RewardCheck = Callable[[str], Sequence[Finding]]
"""Returns what is wrong with the program text of a reward."""

_LONGEST_IDEA = 200
_QUOTED_PARAMETERS = re.compile("[\"'\u201c-\u201f\u2018-\u201b;]parameters\\b")


class InvalidReply(Exception):
    """A reply that cannot be used, with its `errors` in words that the model can act on."""

    def __init__(self, errors: Sequence[str]) -> None:
        super().__init__("; ".join(errors))
        self.errors = tuple(errors)


def parse_morphology(
    reply: str, task: Task, taken: Sequence[Morphology] = (), truncated: bool = False
) -> Morphology:
    """Return the morphology that a reply proposes.

    Args:
        reply: JSON with `parameters` (by name, or a list in order) and `description`, or with the
            names of the parameters beside `description`. Fences, prose and comments around it are
            accepted, and values with units that measure the same.
        task: the task, whose parameters, bounds and rules apply.
        taken: morphologies that must not be proposed again.
        truncated: whether the provider cut the reply off.

    Raises:
        InvalidReply: the reply proposes no valid new morphology.
    """
    try:
        found = _morphology_in(reply, task)
    except NotFound as error:
        raise InvalidReply([*_truncation(truncated), str(error)]) from None
    try:
        values = task.check(read_parameters(found, task))
    except NoNumber as error:
        raise InvalidReply([str(error)]) from None
    except InvalidMorphology as error:
        raise InvalidReply([str(error).removeprefix(f"{task.id}: ")]) from None
    _refuse_repeats("morphology", [_same(earlier.parameters, values) for earlier in taken])
    return Morphology(values, _one_line(found.get("description", "")))


def parse_reward(
    reply: str,
    taken: Sequence[Reward] = (),
    truncated: bool = False,
    check: RewardCheck = check_reward,
) -> Reward:
    """Return the reward that a reply proposes.

    Args:
        reply: Python code. Fences and prose around it are accepted.
        taken: rewards that must not be proposed again.
        truncated: whether the provider cut the reply off.
        check: returns what is wrong with the code.

    Raises:
        InvalidReply: the reply proposes no valid new reward. It holds every error of the code.
    """
    try:
        code, closed = find_code(reply, NAME)
    except NotFound as error:
        raise InvalidReply([*_truncation(truncated), str(error)]) from None
    errors = _truncation(truncated and not closed)
    errors += error_messages(check(code))
    if errors:
        raise InvalidReply(errors)
    normalized = _normalized(code)
    _refuse_repeats("reward", [_normalized(earlier.source) == normalized for earlier in taken])
    return Reward(code.rstrip() + "\n", _idea(code))


def unreadable(reply: str, kind: str, task: Task) -> str:
    """Return why nothing in a reply can be read as a design, or an empty text if something can.

    Args:
        reply: the answer of a model.
        kind: `morphology` or `reward`, which was asked for.
        task: what it is to be designed for.
    """
    try:
        if kind == "morphology":
            _morphology_in(reply, task)
        else:
            find_code(reply, NAME)
    except Unreadable as error:
        return str(error)
    except NotFound:
        pass
    return ""


def error_messages(findings: Sequence[Finding]) -> list[str]:
    """Return the findings that make a reward unusable as messages."""
    return messages([finding for finding in findings if finding.severity == "error"])


def messages(findings: Sequence[Finding]) -> list[str]:
    """Return findings as messages to a model, each with its line."""
    return [f"line {finding.line}: {finding.message}" for finding in findings]


def _morphology_in(reply: str, task: Task) -> dict[str, Any]:
    """Return the JSON object with `parameters`, also for one that has their names at its top.

    Raises:
        NotFound: there is none, or several differ.
    """
    try:
        return find_object(reply, "parameters")
    except Unreadable as error:
        first = next((name for name in task.names if name in reply), None)
        # Beside `parameters` in quotes the names may stand in a piece of what was meant.
        if first is None or _QUOTED_PARAMETERS.search(reply):
            raise
        try:
            found = find_object(reply, first)
        except Unreadable:
            raise error from None
    named = {name: value for name, value in found.items() if name in task.names}
    return {**found, "parameters": named}


def _refuse_repeats(kind: str, same: list[bool]) -> None:
    if True in same:
        number = same.index(True) + 1
        raise InvalidReply([f"this is the same {kind} as number {number} of those before it"])


def _truncation(truncated: bool) -> list[str]:
    return ["the answer was cut off at the length limit; answer more briefly"] if truncated else []


def _same(one: Sequence[float], other: Sequence[float]) -> bool:
    """Return whether two morphologies agree to six digits."""
    return len(one) == len(other) and all(
        abs(a - b) <= 1e-6 * max(abs(a), abs(b)) for a, b in zip(one, other, strict=True)
    )


def _normalized(code: str) -> str:
    """Return a form of the code that layout, comments and docstrings do not change."""
    tree = parsed(code)
    if tree is None:
        return code
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Module):
            node.body = [inner for inner in node.body if not _is_text(inner)]
    try:
        return ast.dump(tree)
    except RecursionError:
        return code


def _is_text(node: ast.stmt) -> bool:
    match node:
        case ast.Expr(value=ast.Constant(value=str())):
            return True
    return False


def _idea(code: str) -> str:
    """Return the first line of the code's docstring, or its first comment."""
    tree = parsed(code)
    if tree is not None:
        functions = [n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == NAME]
        for docstring in (*map(ast.get_docstring, functions), ast.get_docstring(tree)):
            if docstring:
                return _one_line(docstring.strip().split("\n")[0])
    comment = re.search(r"^[ \t]*#+[ \t]*(\S.*)$", code, re.MULTILINE)
    return _one_line(comment[1]) if comment else ""


def _one_line(text: Any) -> str:
    """Return text as one short line, without control characters that move a terminal's cursor."""
    if not isinstance(text, str):
        return ""
    printable = "".join(c if c.isprintable() else " " for c in text)
    line = " ".join(printable.split())
    return line if len(line) <= _LONGEST_IDEA else line[: _LONGEST_IDEA - 1] + "…"
