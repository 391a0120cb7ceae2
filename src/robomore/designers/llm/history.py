"""What was measured, told to a model within a token budget, and by which rule it was chosen."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from robomore.designers.llm import formatting as telling
from robomore.errors import InputError
from robomore.llm.tokens import estimate_tokens
from robomore.tasks.task import Parameter, Task
from robomore.types import Evaluation, Morphology, Reward

RULES = {
    "best": "the best by score",
    "worst": "the worst by score",
    "different": "the one most different from those already chosen",
    "failed": "the latest that only failed",
    "recent": "the latest",
}
"""What may be taken in turn until the budget is full, and how it is said in the prompt."""


@dataclass(frozen=True, slots=True)
class HistorySettings:
    """How much of the history a prompt holds.

    Attributes:
        tokens: the most that the history may take, as `estimate_tokens` counts.
        rule: names of `RULES` joined by `+`, taken in turn.
    """

    tokens: int = 8000
    rule: str = "best+worst+different+failed"

    @property
    def turns(self) -> tuple[str, ...]:
        """The names in the rule.

        Raises:
            InputError: one of them is unknown.
        """
        names = tuple(self.rule.split("+"))
        unknown = [name for name in names if name not in RULES]
        if unknown:
            raise InputError(
                f"history rule {self.rule!r}: {unknown[0]!r} is none of {', '.join(RULES)} "
                "(join them with +)"
            )
        return names


@dataclass(frozen=True, slots=True)
class Entry:
    """One body, or one reward, with all that was measured of it.

    Attributes:
        text: as it stands in the prompt.
        score: the best of its evaluations that were trained longest, `None` if all failed.
        features: what its distance to others is computed from.
        steps: of that training; screening cuts some short, and these stand below the others.
    """

    text: str
    score: float | None
    features: frozenset[str] | tuple[float, ...]
    steps: int = 0


@dataclass(frozen=True, slots=True)
class SelectedHistory:
    """A history as it stands in a prompt: the entries, and how they were chosen."""

    entries: str
    selection: str


def bodies(
    task: Task, objective: str, current: Reward, history: Sequence[Evaluation]
) -> list[Entry]:
    """Return one entry for each body in `history`, in the order of their first measurement."""
    grouped: dict[tuple[float, ...], list[Evaluation]] = {}
    for evaluation in _distinct(history):
        grouped.setdefault(evaluation.design.morphology.parameters, []).append(evaluation)
    full, entries = full_steps(history), []
    for number, (parameters, measured) in enumerate(grouped.items(), start=1):
        here = [e for e in measured if e.design.reward.source == current.source]
        there = [e for e in measured if e.design.reward.source != current.source]
        lines = [f"## Body {number}", *telling.body(task, measured[0].design.morphology)]
        names = ("With the current reward", "With another reward")
        lines += _results(here, there, names, objective, full)
        entries.append(_entry(lines, measured, objective, _position(task, parameters)))
    return entries


def rewards(objective: str, current: Morphology, history: Sequence[Evaluation]) -> list[Entry]:
    """Return one entry for each reward in `history`, in the order of their first measurement."""
    grouped: dict[str, list[Evaluation]] = {}
    for evaluation in _distinct(history):
        grouped.setdefault(evaluation.design.reward.source, []).append(evaluation)
    full, entries = full_steps(history), []
    for number, (source, measured) in enumerate(grouped.items(), start=1):
        here = [e for e in measured if e.design.morphology.parameters == current.parameters]
        there = [e for e in measured if e.design.morphology.parameters != current.parameters]
        lines = [f"## Reward {number}", *telling.program(measured[0].design.reward)]
        names = ("On the current body", "On another body")
        lines += _results(here, there, names, objective, full)
        words = frozenset(re.findall(r"\w+|[^\w\s]", source))
        entries.append(_entry(lines, measured, objective, words))
    return entries


def full_steps(history: Sequence[Evaluation]) -> int:
    """Return the steps of a training to the end; screening cuts some short of it."""
    return max((e.job.steps for e in history), default=0)


def tell(entries: Sequence[Entry], settings: HistorySettings, what: str) -> SelectedHistory:
    """Return the entries that fit into the budget, in their order, and how they were chosen.

    Args:
        entries: oldest first.
        settings: budget and rule.
        what: plural of what the entries are, for the sentence on the choice.
    """
    chosen = choose(entries, settings)
    text = "\n\n".join(entries[index].text for index in sorted(chosen))
    if len(chosen) == len(entries):
        if not entries:
            return SelectedHistory("(nothing yet)", f"So far no {what} were measured.")
        return SelectedHistory(
            text, f"These are all {len(entries)} {what} that were measured, oldest first."
        )
    in_turn = "; ".join(RULES[name] for name in settings.turns)
    return SelectedHistory(
        text or "(left out)",
        f"These are {len(chosen)} of the {len(entries)} {what} that were measured, oldest first. "
        f"The others were left out for length: entries were taken in turn ({in_turn}) as long as "
        "they fitted.",
    )


def choose(entries: Sequence[Entry], settings: HistorySettings) -> list[int]:
    """Return the indices of the entries that fit, in the order in which they were taken.

    Each name of the rule takes one entry in its turn. What does not fit is passed over, so a long
    entry costs only itself; of equal ones the oldest is taken.
    """
    left = settings.tokens
    waiting = list(range(len(entries)))
    chosen: list[int] = []
    while waiting:
        before = len(waiting)
        for name in settings.turns:
            pick = _PICKS[name](entries, waiting, chosen)
            if pick is None:
                continue
            waiting.remove(pick)
            cost = estimate_tokens(entries[pick].text) + 2
            if cost <= left:
                left -= cost
                chosen.append(pick)
        if len(waiting) == before:
            break
    return chosen


def _distinct(history: Sequence[Evaluation]) -> list[Evaluation]:
    """Return each evaluation once: a design that was proposed twice was measured once."""
    return list({evaluation.key: evaluation for evaluation in history}.values())


def _results(
    here: Sequence[Evaluation],
    there: Sequence[Evaluation],
    names: tuple[str, str],
    objective: str,
    full: int,
) -> list[str]:
    """Tell in full what was measured with the other half at hand, and sum up the rest.

    Where nothing succeeded at hand, the best of the rest is told in full instead.
    """
    at_hand, other = names
    lines = [line for e in here for line in telling.result(e, at_hand, full)]
    if not any(e.ok for e in here) and (best := _best_of(there, objective)):
        lines += telling.result(best, f"{other}, its best", full)
        there = [e for e in there if e is not best]
    return lines + telling.results(there, other, full)


def _entry(
    lines: Sequence[str],
    measured: Sequence[Evaluation],
    objective: str,
    features: frozenset[str] | tuple[float, ...],
) -> Entry:
    best = _best_of(measured, objective)
    text = "\n".join(lines)
    if best is None:
        return Entry(text, None, features)
    return Entry(text, best.score(objective), features, best.job.steps)


def _best_of(evaluations: Sequence[Evaluation], objective: str) -> Evaluation | None:
    """Return the best of those that were trained longest, the first among equals."""
    scored = [
        (e.job.steps, score, e) for e in evaluations if (score := e.score(objective)) is not None
    ]
    return max(scored, key=lambda found: found[:2])[2] if scored else None


def _position(task: Task, parameters: Sequence[float]) -> tuple[float, ...]:
    """Return a body as a point in the unit cube of the bounds, each on its own scale."""
    return tuple(
        _fraction(parameter, value)
        for parameter, value in zip(task.parameters, parameters, strict=True)
    )


def _fraction(parameter: Parameter, value: float) -> float:
    low, high = parameter.low, parameter.high
    if parameter.scale == "log":
        low, high, value = math.log(low), math.log(high), math.log(value)
    return (value - low) / (high - low)


def _distance(one: Entry, other: Entry) -> float:
    a, b = one.features, other.features
    if isinstance(a, frozenset) and isinstance(b, frozenset):
        return 1 - len(a & b) / max(1, len(a | b))
    return math.dist(tuple(map(float, a)), tuple(map(float, b)))


def _scored(
    entries: Sequence[Entry], waiting: Sequence[int]
) -> list[tuple[tuple[int, float], int]]:
    """Return standing and index of those with a score: the longer trained stand higher."""
    return [
        ((entries[i].steps, score), i) for i in waiting if (score := entries[i].score) is not None
    ]


def _best(entries: Sequence[Entry], waiting: Sequence[int], chosen: Sequence[int]) -> int | None:
    scored = _scored(entries, waiting)
    return max(scored, key=lambda pair: (pair[0], -pair[1]))[1] if scored else None


def _worst(entries: Sequence[Entry], waiting: Sequence[int], chosen: Sequence[int]) -> int | None:
    scored = _scored(entries, waiting)
    return min(scored)[1] if scored else None


def _different(
    entries: Sequence[Entry], waiting: Sequence[int], chosen: Sequence[int]
) -> int | None:
    if not chosen:
        return _best(entries, waiting, chosen)
    apart = {i: min(_distance(entries[i], entries[j]) for j in chosen) for i in waiting}
    return max(waiting, key=lambda i: (apart[i], -i), default=None)


def _failed(entries: Sequence[Entry], waiting: Sequence[int], chosen: Sequence[int]) -> int | None:
    return max((i for i in waiting if entries[i].score is None), default=None)


def _recent(entries: Sequence[Entry], waiting: Sequence[int], chosen: Sequence[int]) -> int | None:
    return max(waiting, default=None)


_PICKS: dict[str, Callable[[Sequence[Entry], Sequence[int], Sequence[int]], int | None]] = {
    "best": _best,
    "worst": _worst,
    "different": _different,
    "failed": _failed,
    "recent": _recent,
}
