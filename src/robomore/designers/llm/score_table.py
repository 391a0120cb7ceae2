"""All designs that were measured, as one table in the order of their scores."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from statistics import fmean, median, stdev

from robomore.designers.llm.formatting import failure
from robomore.designers.llm.objectives import score_label
from robomore.designers.llm.tables import table
from robomore.llm.tokens import estimate_tokens
from robomore.tasks.task import Task
from robomore.types import Design, Evaluation

_LONGEST_NOTE = 60
_LONGEST_IDEA = 80


class Numbers:
    """Numbers of morphologies and rewards, in the order in which they were measured first."""

    def __init__(self, history: Sequence[Evaluation]) -> None:
        self._morphologies: dict[Hashable, int] = {}
        self._rewards: dict[Hashable, int] = {}
        self._ideas: dict[int, str] = {}
        for evaluation in history:
            design = evaluation.design
            parameters, source = design.morphology.parameters, design.reward.source
            self._morphologies.setdefault(parameters, len(self._morphologies) + 1)
            number = self._rewards.setdefault(source, len(self._rewards) + 1)
            self._ideas.setdefault(number, design.reward.idea)

    def morphology(self, design: Design) -> str:
        """Return for example `morphology 3`."""
        return f"morphology {self._morphologies.get(design.morphology.parameters, '?')}"

    def reward(self, design: Design) -> str:
        """Return for example `reward 2`."""
        return f"reward {self._rewards.get(design.reward.source, '?')}"

    def reward_ideas(self) -> list[str]:
        """Return one line for each reward."""
        return [
            f"- reward {number}: {idea[:_LONGEST_IDEA] or '(no idea given)'}"
            for number, idea in self._ideas.items()
        ]


@dataclass(frozen=True, slots=True)
class _Row:
    """One design with the evaluations that have the most training steps, one for each seed."""

    design: Design
    seeds: tuple[Evaluation, ...]
    steps: int
    score: float | None


def score_table(
    task: Task,
    objective: str,
    history: Sequence[Evaluation],
    numbers: Numbers,
    tokens: int,
    parameters: bool,
) -> str:
    """Return the table, as many of its first rows as fit.

    Args:
        task: the task.
        objective: what decides the order.
        history: all evaluations.
        numbers: of their morphologies and rewards.
        tokens: the most that the table may take.
        parameters: whether the parameters of the morphologies are shown.
    """
    rows = _rows(history, objective)
    full = max((row.steps for row in rows), default=0)
    shown = dict.fromkeys((objective, "efficiency", "fitness"))
    head = [*(score_label(name, task.goal) for name in shown), "volume (m³)"]
    head += ["morphology", "reward", "trained"]
    head += [*(task.names if parameters else ()), "what happened"]
    cells = [_cells(task, row, numbers, full, parameters, list(shown)) for row in rows]
    kept = len(cells)
    lines = table(head, cells)
    cost = [estimate_tokens(line + "\n") for line in lines]
    while kept and sum(cost[: kept + 2]) > tokens:
        kept -= 1
    lines = lines[: kept + 2] if kept else ["(left out for length)"]
    if kept < len(cells):
        lines.append(f"\n{len(cells) - kept} designs below these were left out for length.")
    return "\n".join(lines)


def spread_sentence(history: Sequence[Evaluation], objective: str) -> str:
    """Return how far scores of the same design differ between training seeds."""
    differences = []
    for row in _rows(history, objective):
        scores = [s for e in row.seeds if (s := e.score(objective)) is not None]
        if len(scores) > 1:
            mean = abs(fmean(scores)) or 1.0
            differences.append((max(scores) - min(scores)) / mean)
    if not differences:
        return (
            "No design was trained with a second seed so far, so a small difference between two "
            "designs may be chance."
        )
    return (
        f"{len(differences)} designs were trained with several seeds. Their scores differed by "
        f"{100 * median(differences):.0f} % (median of the largest difference, as a share of the "
        "mean). A smaller difference between two designs may be chance."
    )


def _rows(history: Sequence[Evaluation], objective: str) -> list[_Row]:
    grouped: dict[Hashable, list[Evaluation]] = defaultdict(list)
    for evaluation in {e.key: e for e in history}.values():
        design = evaluation.design
        grouped[design.morphology.parameters, design.reward.source].append(evaluation)
    rows = []
    for measured in grouped.values():
        steps = max((e.job.steps for e in measured if e.ok), default=0)
        seeds = tuple(e for e in measured if e.ok and e.job.steps == steps) or tuple(measured[:1])
        scores = [score for e in seeds if (score := e.score(objective)) is not None]
        rows.append(_Row(measured[0].design, seeds, steps, fmean(scores) if scores else None))
    rows.sort(key=lambda row: (row.score is not None, row.steps, row.score or 0.0), reverse=True)
    return rows


def _cells(
    task: Task,
    row: _Row,
    numbers: Numbers,
    full: int,
    parameters: bool,
    shown: Sequence[str],
) -> list[str]:
    first = row.seeds[0]
    values = [f"{value:.4g}" for value in row.design.morphology.parameters] if parameters else []
    names = [
        numbers.morphology(row.design).partition(" ")[2],
        numbers.reward(row.design).partition(" ")[2],
    ]
    if row.score is None:
        return [*("" for _ in shown), "", *names, "", *values, failure(first)[:_LONGEST_NOTE]]
    trained = "100 %" if row.steps == full else f"{100 * row.steps / full:.0f} %"
    scores = [
        ", ".join(
            _with_spread(e) if name == "fitness" else f"{e.score(name) or 0.0:.4g}"
            for e in row.seeds
        )
        for name in shown
    ]
    volume = f"{first.volume or 0.0:.4g}"
    return [*scores, volume, *names, trained, *values, fall(first)]


def _with_spread(evaluation: Evaluation) -> str:
    episodes = evaluation.episode_fitness
    spread = f" ± {stdev(episodes):.2g}" if len(episodes) > 1 else ""
    return f"{evaluation.fitness or 0.0:.4g}{spread}"


def fall(evaluation: Evaluation) -> str:
    """Return how many episodes ended early, and why, or an empty text if none did."""
    behaviour = evaluation.behaviour
    if not behaviour.get("fell_share"):
        return ""
    causes = {
        "fell_too_low_share": "too low",
        "fell_too_high_share": "too high",
        "fell_tilted_share": "tilted",
        "fell_diverged_share": "simulation diverged",
        "fell_unhealthy_share": "not healthy",
    }
    why = [word for name, word in causes.items() if behaviour.get(name)]
    share = f"{100 * behaviour['fell_share']:.0f} % of episodes ended early"
    return f"{share} ({', '.join(why)})" if why else share
