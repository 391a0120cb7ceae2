"""From a reply to a typed proposal, or to the exact faults that go back to the model."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Sequence
from typing import Any

from robomore.designers.llm.extraction import NotFound, find_code, find_object
from robomore.errors import InvalidMorphology
from robomore.rewards.check import NAME, Finding, check_reward
from robomore.tasks.task import Task
from robomore.types import Morphology, Reward

Check = Callable[[str], Sequence[Finding]]
"""Looks at the text of a reward and says what is wrong with it."""

_LONGEST_IDEA = 200
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?")


class BadReply(Exception):
    """A reply that cannot be used.

    Attributes:
        faults: each in words that the model can act on.
    """

    def __init__(self, faults: Sequence[str]) -> None:
        super().__init__("; ".join(faults))
        self.faults = tuple(faults)


def parse_morphology(
    reply: str, task: Task, taken: Sequence[Morphology] = (), truncated: bool = False
) -> Morphology:
    """Return the body that a reply proposes.

    Args:
        reply: JSON with `parameters` (by name, or a list in order) and `description`, perhaps with
            fences, prose or comments around it.
        task: whose parameters, bounds and rules apply.
        taken: bodies that must not be proposed again.
        truncated: the provider cut the reply off.

    Raises:
        BadReply: with every fault.
    """
    try:
        found = find_object(reply, "parameters")
    except NotFound as fault:
        raise BadReply([*_cut_off(truncated), str(fault)]) from None
    try:
        values = task.check(_numbers(found["parameters"]))
    except InvalidMorphology as error:
        raise BadReply([str(error).removeprefix(f"{task.id}: ")]) from None
    for number, earlier in enumerate(taken, start=1):
        if _same(earlier.parameters, values):
            raise BadReply([f"this is the same body as number {number} of those before it"])
    return Morphology(values, _one_line(found.get("description", "")))


def parse_reward(
    reply: str,
    taken: Sequence[Reward] = (),
    truncated: bool = False,
    check: Check = check_reward,
) -> Reward:
    """Return the reward that a reply proposes.

    Args:
        reply: Python code, perhaps with fences or prose around it.
        taken: rewards that must not be proposed again.
        truncated: the provider cut the reply off.
        check: finds faults in the code.

    Raises:
        BadReply: with every fault.
    """
    try:
        code, closed = find_code(reply, NAME)
    except NotFound as fault:
        raise BadReply([*_cut_off(truncated), str(fault)]) from None
    faults = _cut_off(truncated and not closed)
    faults += [*errors(check(code)), *_other_names(code)]
    if faults:
        raise BadReply(faults)
    shape = _shape(code)
    for number, earlier in enumerate(taken, start=1):
        if _shape(earlier.source) == shape:
            raise BadReply([f"this is the same reward as number {number} of those before it"])
    return Reward(code.rstrip() + "\n", _idea(code))


def errors(findings: Sequence[Finding]) -> list[str]:
    """Return the findings that keep a reward from being trained, each with its line."""
    return in_words([finding for finding in findings if finding.severity == "error"])


def in_words(findings: Sequence[Finding]) -> list[str]:
    """Return findings as they are told to a model, each with its line."""
    return [f"line {finding.line}: {finding.message}" for finding in findings]


def _cut_off(truncated: bool) -> list[str]:
    return ["the answer was cut off at the length limit; answer more briefly"] if truncated else []


def _numbers(given: Any) -> Any:
    """Return `given` with its values as numbers, or say which are none."""
    if isinstance(given, dict):
        return {str(name): _number(str(name), value) for name, value in given.items()}
    if isinstance(given, list | tuple):
        return [_number(f"number {i}", value) for i, value in enumerate(given, start=1)]
    raise BadReply([f'"parameters" is {_shown(given)}; give an object by name, or a list'])


def _number(name: str, value: Any) -> float:
    if isinstance(value, str) and _NUMBER.fullmatch(value.strip()):
        value = value.strip()
    elif isinstance(value, bool) or not isinstance(value, int | float):
        raise BadReply([f"{name} is {_shown(value)}; give a plain number"])
    try:
        return float(value)
    except OverflowError:
        raise BadReply([f"{name} is no finite number"]) from None


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:60] + "…"


def _same(one: Sequence[float], other: Sequence[float]) -> bool:
    """Return whether two bodies agree to six digits."""
    return len(one) == len(other) and all(
        abs(a - b) <= 1e-6 * max(abs(a), abs(b)) for a, b in zip(one, other, strict=True)
    )


def _other_names(code: str) -> list[str]:
    """Say what the function is called, where it is not called as it must be."""
    tree = _tree(code)
    if tree is None:
        return []
    names = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
    if names and NAME not in names:
        return [f"the function is called `{names[-1]}`; call it `{NAME}`"]
    return []


def _shape(code: str) -> str:
    """Return what is the same for two rewards that differ in layout, comments and docstrings."""
    tree = _tree(code)
    if tree is None:
        return code
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Module):
            kept = [inner for inner in node.body if not _is_text(inner)]
            node.body = kept
    try:
        return ast.dump(tree)
    except RecursionError:
        return code


def _is_text(node: ast.stmt) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def _idea(code: str) -> str:
    """Return a reward's own first line of explanation."""
    tree = _tree(code)
    if tree is not None:
        functions = [n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == NAME]
        for said in (*map(ast.get_docstring, functions), ast.get_docstring(tree)):
            if said:
                return _one_line(said.strip().split("\n")[0])
    comment = re.search(r"^\s*#+\s*(.+)$", code, re.MULTILINE)
    return _one_line(comment[1]) if comment else ""


def _tree(code: str) -> ast.Module | None:
    try:
        return ast.parse(code)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


def _one_line(said: Any) -> str:
    """Return text as one short line without anything that moves a terminal's cursor."""
    if not isinstance(said, str):
        return ""
    printable = "".join(c if c.isprintable() else " " for c in said)
    line = " ".join(printable.split())
    return line if len(line) <= _LONGEST_IDEA else line[: _LONGEST_IDEA - 1] + "…"
