"""What a reward gets without noticing: a default, a replaced infinity, a list that grows."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from types import FrameType

from robomore.envs.reward_program import NAME, REWARD_FILENAME
from robomore.rewards.dry_run_findings import Observed
from robomore.rewards.finding import Finding
from robomore.rewards.paths import line_of
from robomore.text import one_line

_LONGEST = 100


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
        lasts = "its episode" if name.startswith("self.") else "the whole training"
        first, last = it.seconds
        yield Finding(
            line_of(tree, name.rpartition(".")[2], NAME),
            "warning",
            f"`{one_line(name)[:_LONGEST]}` grows with every call for {lasts}: it held "
            f"{it.amounts[0]:,} values after {it.calls[0]:,} calls and {it.amounts[1]:,} after "
            f"{it.calls[1]:,}, and a call took {1e6 * first:.0f} µs, then {1e6 * last:.0f} µs; "
            "keep a running value, or a `deque(maxlen=…)`",
        )
