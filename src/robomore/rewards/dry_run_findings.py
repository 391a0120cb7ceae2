"""What a reward did on a few robots that moved at random, and what that says about it.

Only messages are made here. `robomore.rewards.dry_run` lets the reward run, in a sandboxed process.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from robomore.envs.reward_program import NAME
from robomore.identity import derive_seed
from robomore.rewards.check import Finding
from robomore.rewards.paths import line_of
from robomore.tasks.task import Task
from robomore.tasks.unit_space import UnitSpace

SLOW, TOO_SLOW = 1e-3, 10e-3
"""Processor seconds of one call. A usual reward takes some 20 microseconds, and training on half a
million steps makes as many calls."""
_DOMINANT = 0.99
"""A term with more than this share of all variation leaves the others without a say."""
TINY, HUGE = 1e-100, 1e100
"""Training normalises rewards; those whose size lies outside it cannot."""
_DIGITS = 1e-10
"""A reward whose values differ by less than this share of their size is as good as constant."""
_ROUNDING = 1e-6
_OUTLIER = 1e6
"""A reward that is so many times its usual size somewhere, is clipped there."""
_NAMED = 3
"""Terms that one finding names."""
_DRAWS = 500


@dataclass(frozen=True, slots=True)
class Term:
    """One reward term in a dry run.

    Attributes:
        spread: its standard deviation over the calls.
        not_finite: calls in which it was no finite number.
        mean: over the calls in which it was a finite number, as for what follows.
        low: least value.
        high: greatest value.
    """

    spread: float = 0.0
    not_finite: int = 0
    mean: float = 0.0
    low: float = 0.0
    high: float = 0.0


@dataclass(frozen=True, slots=True)
class Growth:
    """Something that a reward keeps, and that was larger after each call.

    Attributes:
        values: numbers, letters and objects that one call adds.
        size: memory that one call adds, in bytes, roughly.
        seconds: processor time of a call, after some hundred calls and after a thousand.
        episode_steps: calls after which it starts anew; 0 if it never does.
    """

    values: float
    size: float
    seconds: tuple[float, float]
    episode_steps: int


@dataclass(frozen=True, slots=True)
class Apart:
    """That the terms of a reward do not add up to it.

    Attributes:
        calls: in which they did not.
        total: sum of the terms in the first of them.
        reward: in the same call.
    """

    calls: int
    total: float
    reward: float


@dataclass(frozen=True, slots=True)
class Observed:
    """What was observed of a reward that raised nothing.

    Attributes:
        calls: of the reward, over all morphologies.
        low: least reward.
        high: greatest reward.
        seconds: processor time of a usual call (the median).
        terms: by name.
        mean: of the reward.
        spread: its standard deviation.
        usual: usual size of the reward (the median of its absolute values).
        hidden: by line and kind of fault, as in `3 divide by zero`, calls in which NumPy met it and
            the reward was finite all the same.
        missing: by attribute that was looked for in vain, what was probably meant.
        growth: by name of what is kept.
        lasting: names of what is kept for the whole training, and was changed by calls.
        apart: calls whose terms do not add up to the reward; `None` if all do.
    """

    calls: int
    low: float
    high: float
    seconds: float
    terms: dict[str, Term] = field(default_factory=dict)
    mean: float = 0.0
    spread: float = 0.0
    usual: float = 0.0
    hidden: dict[str, int] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)
    growth: dict[str, Growth] = field(default_factory=dict)
    lasting: tuple[str, ...] = ()
    apart: Apart | None = None


def findings(observed: Observed, source: str) -> list[Finding]:
    """Return what a designer should know about a reward.

    Args:
        observed: in a dry run.
        source: the reward. What concerns a term is said of the line that names it.
    """
    found = []
    tree = ast.parse(source.removeprefix("\ufeff"))
    line = line_of(tree, "", NAME)
    if observed.calls > 1 and observed.low == observed.high:
        found.append(
            Finding(
                line,
                "error",
                f"the reward was the same number ({observed.low:g}) in all {observed.calls} steps "
                "of several robots that moved at random: nothing can be learnt from it",
            )
        )
    else:
        found += _about_size(observed, line)
    if observed.seconds > SLOW:
        found.append(
            Finding(
                line,
                "error" if observed.seconds > TOO_SLOW else "warning",
                f"one call takes {1e3 * observed.seconds:.1f} ms, and training makes hundreds of "
                f"thousands of calls; it should take less than {1e3 * SLOW:g} ms",
            )
        )
    return [*found, *_about_terms(observed, line, partial(line_of, tree, function=NAME))]


def _about_size(observed: Observed, line: int) -> list[Finding]:
    """Tell of values that training cannot use, or will clip."""
    largest = max(abs(observed.low), abs(observed.high))
    spread = observed.high / 2 - observed.low / 2  # halved, so that it is finite
    reached = observed.low if abs(observed.low) == largest else observed.high
    said = f"the reward was {reached:.3g}{_largest_term(observed)}"
    if largest > HUGE:
        said += ", which is too large to learn from; keep it between -1000 and 1000"
    elif largest < TINY:
        said += " at most, which is too small to learn from; multiply it"
    elif 2 * spread < _DIGITS * largest:
        said += (
            f", and differed by only {2 * spread:.3g} in {observed.calls} steps: too few digits "
            "are left to learn from; take the large constant away"
        )
    elif largest > _OUTLIER * observed.usual > 0:
        said += (
            f" in one state and {observed.usual:.3g} in a usual one; such values are clipped: "
            "bound the term, for example with `np.clip` or `np.tanh`"
        )
        return [Finding(line, "warning", said)]
    else:
        return []
    return [Finding(line, "error", said)]


def _largest_term(observed: Observed) -> str:
    sizes = {name: max(term.low, term.high, key=abs) for name, term in observed.terms.items()}
    if not sizes:
        return ""
    name = max(sizes, key=lambda name: abs(sizes[name]))
    return f" (its largest term: {name!r}, {sizes[name]:.3g})"


def morphologies(task: Task, count: int) -> list[tuple[float, ...]]:
    """Return `count` random valid morphologies and the reference, the same ones every time.

    The reference comes last. What fails, mostly fails on another one before it, and so the messages
    that go to a designer do not tell how the reference stands.
    """
    space = UnitSpace(task)
    random = np.random.default_rng(derive_seed("dry run", task.id, task.version))
    found: list[tuple[float, ...]] = []
    # Near the reference, where morphologies are valid more often than elsewhere within the bounds.
    reference = space.units([task.reference])
    for _ in range(_DRAWS):
        if len(found) == count:
            break
        drawn = space.values(reference + random.normal(0.0, 0.15, reference.shape))
        if space.valid(drawn)[0]:
            found.append(tuple(drawn[0].tolist()))
    return [*found, task.reference]


def _about_terms(
    observed: Observed, line: int, line_of_term: Callable[[str], int]
) -> list[Finding]:
    if not observed.terms:
        said = "it returns no terms; give each part of the sum a name, so that one can see its part"
        return [Finding(line, "warning", said)]
    found = []
    faulty = [name for name, term in observed.terms.items() if term.not_finite]
    if faulty:
        said = f"{_listed(faulty)} not always a finite number among the terms"
        found.append(Finding(line_of_term(faulty[0]), "warning", said))
    found += _unchanging(observed, line_of_term)
    found += _drowned(observed, line_of_term)
    if observed.apart:
        it = observed.apart
        said = (
            f"the terms do not add up to the reward in {it.calls} of {observed.calls} calls: "
            f"{it.total:.4g} and {it.reward:.4g} in the first of them. Training uses the reward; "
            "reports and designers see the terms, so return each as it is in the sum, its weight "
            "included"
        )
        found.append(Finding(line, "note", said))
    return found


def _drowned(observed: Observed, line_of_term: Callable[[str], int]) -> list[Finding]:
    """Tell of a term beside which another one that is to be followed is not noticed.

    A small cost of control or a small bonus beside the term that drives the robot is as it should
    be, and official rewards have them. What must not drown is a term that drives: one that is no
    cost (never above 0) and no bonus.
    """
    varying = {name: term for name, term in observed.terms.items() if term.spread > 0}
    total = math.fsum(term.spread for term in varying.values())
    # A constant, such as a bonus for being healthy, is no rival.
    largest = max(varying, key=lambda name: varying[name].spread, default="")
    if not largest or varying[largest].spread <= _DOMINANT * total:
        return []
    drives = [name for name in varying if name != largest and _drives(varying[name])]
    if not drives:
        return []
    second = max(drives, key=lambda name: varying[name].spread)
    above, below = varying[largest].spread, varying[second].spread
    said = (
        f"the term {largest!r} dominates: under random actions it varies {above / below:,.0f} "
        f"times as much as {second!r} (standard deviations {above:.3g} and {below:.3g}), so "
        f"training follows {largest!r} alone and hardly notices {second!r}; give the former a "
        "smaller weight, or the latter a larger one"
    )
    return [Finding(line_of_term(largest), "warning", said)]


def _drives(term: Term) -> bool:
    """Whether a term is neither a cost nor a bonus.

    A bonus is never negative, and is mostly paid: it varies by less than its mean. Or it has two
    values, which alone vary as much as their bounds allow.
    """
    if term.high <= 0:
        return False
    most = math.sqrt(max(0.0, (term.high - term.mean) * (term.mean - term.low)))
    two_values = term.spread > (1 - _ROUNDING) * most
    return term.low < 0 or not (two_values or term.spread < term.mean)


def _unchanging(observed: Observed, line_of_term: Callable[[str], int]) -> list[Finding]:
    """Tell of terms that never change: dead if they are 0, perhaps meant if they are not."""
    same = [name for name, term in observed.terms.items() if term.low == term.high]
    same = [name for name in same if observed.terms[name].not_finite < observed.calls]
    dead = [name for name in same if observed.terms[name].high == 0]
    constant = [name for name in same if name not in dead]
    found = []
    if dead and observed.calls > 1:
        said = f"{_listed(dead)} 0 in all {observed.calls} steps; look at what it is computed from"
        found.append(Finding(line_of_term(dead[0]), "warning", said))
    if constant and observed.calls > 1:
        said = f"{_listed(constant)} the same number in all {observed.calls} steps"
        found.append(Finding(line_of_term(constant[0]), "note", said))
    return found


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(f"{name!r}" for name in names[:_NAMED])
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f"{shown}{more} {'was' if len(names) == 1 else 'were'}"
