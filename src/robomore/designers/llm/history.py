"""Selects the part of the history that fits into the token budget of a prompt, by a named rule."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass

from robomore.designers.llm.formatting import (
    evaluation_lines,
    morphology_lines,
    reward_lines,
)
from robomore.designers.llm.score_table import Numbers
from robomore.errors import InputError
from robomore.llm.tokens import estimate_tokens
from robomore.tasks.fitness import Fitness
from robomore.tasks.task import Task
from robomore.tasks.unit_space import UnitSpace
from robomore.types import Curve, Design, Evaluation, Morphology, Reward

RULES = {
    "best": "the best by score",
    "worst": "the worst by score",
    "different": "the one most different from those already chosen",
    "failed": "the latest that only failed",
    "recent": "the latest",
}
"""The names that a rule may hold, and the words for them in the prompt."""

CurveOf = Callable[[str], Curve | None]
"""Returns the learning curve of the evaluation with that key."""

Features = frozenset[str] | tuple[float, ...]


@dataclass(frozen=True, slots=True)
class HistorySettings:
    """How much of the history a prompt holds.

    Attributes:
        tokens: the most tokens that the history may take, as `estimate_tokens` counts them.
        rule: names of `RULES` joined by `+`. Each name in turn selects one entry.
    """

    tokens: int = 4000
    rule: str = "best+worst+different+failed"

    def __post_init__(self) -> None:
        """Raise `InputError` for a negative number of tokens or an unknown name in the rule."""
        if self.tokens < 0:
            raise InputError(f"history tokens = {self.tokens} is less than 0")
        unknown = [name for name in self.rule_names if name not in RULES]
        if unknown:
            raise InputError(
                f"history rule {self.rule!r}: {unknown[0]!r} is none of {', '.join(RULES)} "
                "(join them with +)"
            )

    @property
    def rule_names(self) -> tuple[str, ...]:
        return tuple(self.rule.split("+"))


@dataclass(frozen=True, slots=True)
class Entry:
    """One morphology, or one reward, with all of its evaluations.

    Attributes:
        text: the text in the prompt.
        score: the best score of its evaluations with the most steps, `None` if all failed.
        features: the features that the distance to other entries is computed from.
        steps: training steps of that score. Fewer steps rank below more steps, because screening
            stopped them early.
    """

    text: str
    score: float | None
    features: Features
    steps: int = 0


@dataclass(frozen=True, slots=True)
class SelectedHistory:
    """The selected entries as one text, and a sentence on how they were selected."""

    entries: str
    selection: str


def morphology_entries(
    task: Task,
    objective: str,
    current: Reward,
    history: Sequence[Evaluation],
    curve_of: CurveOf = lambda key: None,
) -> list[Entry]:
    """Return one entry for each morphology in `history`, oldest first."""
    space = UnitSpace(task)
    return _entries(
        history,
        objective,
        task.goal,
        key=lambda design: design.morphology.parameters,
        is_current=lambda design: design.reward.source == current.source,
        label="With the current reward",
        partner=Numbers(history).reward,
        curve_of=curve_of,
        heading="Morphology",
        describe=lambda design: morphology_lines(task, design.morphology),
        features=lambda design: tuple(space.units([design.morphology.parameters])[0].tolist()),
    )


def reward_entries(
    task: Task,
    objective: str,
    current: Morphology,
    history: Sequence[Evaluation],
    curve_of: CurveOf = lambda key: None,
) -> list[Entry]:
    """Return one entry for each reward in `history`, oldest first."""
    return _entries(
        history,
        objective,
        task.goal,
        key=lambda design: design.reward.source,
        is_current=lambda design: design.morphology.parameters == current.parameters,
        label="With the current morphology",
        partner=Numbers(history).morphology,
        curve_of=curve_of,
        heading="Reward",
        describe=lambda design: reward_lines(design.reward),
        features=lambda design: frozenset(re.findall(r"\w+|[^\w\s]", design.reward.source)),
    )


def full_steps(history: Sequence[Evaluation]) -> int:
    """Return the steps of a full training. Screening stops others after fewer steps."""
    return max((e.job.steps for e in history), default=0)


def select(entries: Sequence[Entry], settings: HistorySettings, plural: str) -> SelectedHistory:
    """Return the entries that fit into the token budget, oldest first.

    `plural` is the plural of what an entry is, for the sentence on the selection.
    """
    chosen = choose(entries, settings)
    text = "\n\n".join(entries[index].text for index in sorted(chosen))
    if len(chosen) == len(entries):
        if not entries:
            return SelectedHistory("(nothing yet)", f"So far no {plural} were measured.")
        return SelectedHistory(
            text, f"These are all {len(entries)} {plural} that were measured, oldest first."
        )
    rule = "; ".join(RULES[name] for name in settings.rule_names)
    return SelectedHistory(
        text or "(left out)",
        f"These are {len(chosen)} of the {len(entries)} {plural} that were measured, oldest first. "
        f"The others were left out for length: entries were taken in turn ({rule}) as long as "
        "they fitted.",
    )


def choose(entries: Sequence[Entry], settings: HistorySettings) -> list[int]:
    """Return the indices of the entries that fit, in the order in which they were chosen.

    Each name of the rule chooses one entry in turn. An entry that does not fit is left out, and the
    choice goes on with the others. Among equal entries the oldest is chosen.
    """
    left = settings.tokens
    waiting = list(range(len(entries)))
    chosen: list[int] = []
    while waiting:
        before = len(waiting)
        for name in settings.rule_names:
            pick = _pick(name, entries, waiting, chosen)
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


def _entries(
    history: Sequence[Evaluation],
    objective: str,
    goal: Fitness,
    *,
    key: Callable[[Design], Hashable],
    is_current: Callable[[Design], bool],
    label: str,
    partner: Callable[[Design], str],
    curve_of: CurveOf,
    heading: str,
    describe: Callable[[Design], list[str]],
    features: Callable[[Design], Features],
) -> list[Entry]:
    """Group the evaluations by `key`, and make one entry of each group."""
    grouped: dict[Hashable, list[Evaluation]] = defaultdict(list)
    # A design that was proposed twice was measured once.
    for evaluation in {e.key: e for e in history}.values():
        grouped[key(evaluation.design)].append(evaluation)
    full, entries = full_steps(history), []
    for number, measured in enumerate(grouped.values(), start=1):
        design = measured[0].design
        here = [e for e in measured if is_current(e.design)]
        there = [e for e in measured if not is_current(e.design)]
        lines = [f"## {heading} {number}", *describe(design)]
        for one in here:
            lines += evaluation_lines(one, label, goal, objective, full, curve_of(one.key))
        # If none with the current partner succeeded, the best of the others is described in full.
        # All the others stand in the table.
        if not any(e.ok for e in here) and (shown := _best_of(there, objective)):
            lines += evaluation_lines(
                shown,
                f"With {partner(shown.design)}, its best",
                goal,
                objective,
                full,
                curve_of(shown.key),
            )
        text = "\n".join(lines)
        best = _best_of(measured, objective)
        score, steps = (best.score(objective), best.job.steps) if best else (None, 0)
        entries.append(Entry(text, score, features(design), steps))
    return entries


def _best_of(evaluations: Sequence[Evaluation], objective: str) -> Evaluation | None:
    """Return the best of those with the most training steps, the first among equals."""
    scored = [
        (e.job.steps, score, e) for e in evaluations if (score := e.score(objective)) is not None
    ]
    return max(scored, key=lambda found: found[:2])[2] if scored else None


def _distance(one: Entry, other: Entry) -> float:
    a, b = one.features, other.features
    if isinstance(a, frozenset) and isinstance(b, frozenset):
        return 1 - len(a & b) / max(1, len(a | b))
    return math.dist(tuple(map(float, a)), tuple(map(float, b)))


def _pick(
    name: str, entries: Sequence[Entry], waiting: Sequence[int], chosen: Sequence[int]
) -> int | None:
    """Return the entry that one name of the rule selects, the oldest among equals."""

    def rank(i: int) -> tuple[int, float]:
        return entries[i].steps, entries[i].score or 0.0

    scored = [i for i in waiting if entries[i].score is not None]
    match name:
        case "different" if chosen:
            apart = {i: min(_distance(entries[i], entries[j]) for j in chosen) for i in waiting}
            return max(waiting, key=lambda i: apart[i], default=None)
        case "best" | "different":
            return max(scored, key=rank, default=None)
        case "worst":
            return min(scored, key=rank, default=None)
        case "failed":
            return max((i for i in waiting if entries[i].score is None), default=None)
    return max(waiting, default=None)
