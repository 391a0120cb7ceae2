"""What a reward gets without noticing: a default, a replaced infinity, a list that grows."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from types import FrameType

from robomore.envs.reward_program import NAME, REWARD_FILENAME
from robomore.rewards.dry_run_findings import Observed
from robomore.rewards.finding import Finding
from robomore.rewards.paths import line_of, path_of
from robomore.rewards.rules import kept_for_training
from robomore.text import one_line
from robomore.types import Limits

_LONGEST = 100
_SLOWER, _NOTICED = 1.5, 5e-6
"""How many times as long as before a call must take to be told of as slower, and how many seconds
longer."""


def line_now(frame: FrameType | None) -> int:
    """Return the line of the reward that is being executed, 0 if none is.

    Args:
        frame: from which its callers are looked through.
    """
    while frame is not None and frame.f_code.co_filename != REWARD_FILENAME:
        frame = frame.f_back
    return frame.f_lineno if frame is not None else 0


def silent_findings(observed: Observed, source: str) -> list[Finding]:
    """Return findings about what a dry run has shown, and the reward has hidden.

    Args:
        observed: in a dry run.
        source: the reward.
    """
    try:
        tree = ast.parse(source.removeprefix("\ufeff"))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return []
    return [
        *_hidden(observed, "nan_to_num" in source),
        *_missing(observed, tree),
        *_growth(observed, tree),
        *_lasting(observed, tree),
    ]


def _hidden(observed: Observed, replaced: bool) -> Iterator[Finding]:
    gets = "it was finite all the same, so something hides it"
    if replaced:
        gets = "`np.nan_to_num` gives 0 for NaN and 1.8e+308 for infinity in its place"
    for fault, calls in observed.hidden.items():
        number, _, kind = fault.partition(" ")
        line = int(number) if number.isdecimal() and len(number) < 9 else 0
        yield Finding(
            max(line, 1),
            "warning" if replaced else "note",
            f"{one_line(kind)[:_LONGEST]} in {calls} of {observed.calls} calls; {gets}: compute it "
            "only where it is defined",
        )


def _missing(observed: Observed, tree: ast.Module) -> Iterator[Finding]:
    assigned = {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and not isinstance(node.ctx, ast.Load)
    }
    for path, near in observed.missing.items():
        name = path.rpartition(".")[2]
        if name in assigned:
            continue
        hint = f"; did you mean `{one_line(near)[:_LONGEST]}`?" if near else ""
        yield Finding(
            line_of(tree, name, NAME),
            "warning",
            f"there is no `{one_line(path)[:_LONGEST]}`: `getattr` gives its default and `hasattr` "
            f"gives False in every step{hint}",
        )


def _growth(observed: Observed, tree: ast.Module) -> Iterator[Finding]:
    for name, it in observed.growth.items():
        each = f"by {it.values:,.0f} value{'s' if round(it.values) != 1 else ''} a call"
        if it.episode_steps:
            most = f"{it.values * it.episode_steps:,.0f} values"
            lasts = f"until its episode ends, {each}, to {most} after {it.episode_steps:,} steps"
        else:
            lasts = f"for the whole training, {each}{_full(it.size)}"
        first, last = it.seconds
        slower = last > _SLOWER * first and last - first > _NOTICED
        longer = ", and each call takes longer than the one before" if slower else ""
        yield Finding(
            _line(tree, name),
            "warning",
            f"{_shown(name)} grows with every call {lasts}{longer}; keep a running value, or a "
            "`deque(maxlen=…)`",
        )


def _full(size: float) -> str:
    """Return after how many steps a training's memory is full, if a call adds `size` bytes."""
    if size <= 0:
        return ""
    most = Limits().memory_bytes
    steps = int(float(f"{most / size:.2g}"))
    return (
        f" ({size:,.0f} bytes): the {most / 2**30:g} GiB of an evaluation would be full after some "
        f"{steps:,} control steps"
    )


def _lasting(observed: Observed, tree: ast.Module) -> Iterator[Finding]:
    """Tell what a call has changed outside of `self`, where nothing else has told it."""
    told = {
        name
        for node in ast.walk(tree)
        if isinstance(node, ast.Global | ast.Nonlocal)
        for name in node.names
    }
    for name in observed.lasting:
        if name not in told and name not in observed.growth:
            yield Finding(_line(tree, name), "note", kept_for_training(_shown(name)))


def _shown(name: str) -> str:
    """Return how a name of `robomore.envs.reward_amount.parts` is said."""
    name = one_line(name)[:_LONGEST]
    function, argument = _argument(name)
    return f"the default argument `{argument}` of `{function}`" if argument else f"`{name}`"


def _line(tree: ast.Module, name: str) -> int:
    function, argument = _argument(name)
    if not argument:
        path = name.split(".")
        written = [
            node.lineno
            for node in ast.walk(tree)
            if isinstance(node, ast.Attribute) and path_of(node) == path
        ]
        return min(written, default=line_of(tree, path[-1], NAME))
    lines = [
        one.lineno
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and node.name == function
        for one in ast.walk(node.args)
        if isinstance(one, ast.arg) and one.arg == argument
    ]
    return min(lines, default=line_of(tree, "", NAME))


def _argument(name: str) -> tuple[str, str]:
    function, _, argument = name.partition("(")
    return function, argument.removesuffix("=…)")
