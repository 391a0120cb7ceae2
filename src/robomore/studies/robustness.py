"""A champion in other worlds: with other motors, and on other grounds (paper, Appendix).

One search finds the design. It is then trained anew in each of the other tasks, and crossed with
the reference design as in any final.
"""

from __future__ import annotations

from functools import partial
from statistics import fmean

from robomore.runs.words import label, unit_of
from robomore.studies.study import Arm, Draw, Results, Study
from robomore.studies.table import Entry, Table
from robomore.tasks import get_task
from robomore.tasks.variants import GEARS
from robomore.visualize.studies import by_task

FOUND, HUMAN = "the found design", "the human design"


def _scores(results: Results, task: str) -> dict[str, list[float]]:
    """Return what each of the two is worth in a task, one number for each run."""
    found: dict[str, list[float]] = {FOUND: [], HUMAN: []}
    for run in results.runs(task):
        for name, design in ((FOUND, run.found), (HUMAN, run.reference)):
            measured = design.score(results.objective) if design else None
            if measured:
                found[name].append(measured.mean)
    return found


def _tables(results: Results) -> list[Table]:
    rows: list[tuple[Entry, ...]] = []
    for task in results.tasks:
        designs = [run.found for run in results.runs(task) if run.found]
        fitness = [one.fitness.mean for one in designs if one.fitness]
        scores = _scores(results, task)
        found, human = scores[FOUND], scores[HUMAN]
        rows.append(
            (
                get_task(task).title,
                fmean(found) if found else None,
                min(found, default=None),
                max(found, default=None),
                fmean(fitness) if fitness else None,
                fmean(human) if human else None,
                len(found),
            )
        )
    unit = unit_of(results.objective, results.fitness_unit) or "no unit"
    columns = ("task", f"mean ({unit})", f"lowest run ({unit})", f"highest run ({unit})")
    return [
        Table(
            "robustness",
            f"One design, found in {get_task(results.tasks[0]).title}, trained anew in each task: "
            f"{label(results.objective, results.fitness_unit)}",
            (*columns, label("fitness", results.fitness_unit), f"human design ({unit})", "runs"),
            tuple(rows),
            "Each run searches in the first task, and trains what it found in all of them.",
        )
    ]


def _figures(results: Results) -> dict[str, Draw]:
    lines: dict[str, dict[str, list[float]]] = {FOUND: {}, HUMAN: {}}
    for task in results.tasks:
        for name, scores in _scores(results, task).items():
            if scores:
                lines[name][get_task(task).title] = scores
    drawn = {name: line for name, line in lines.items() if line}
    return (
        {"robustness": partial(by_task, drawn, label(results.objective, results.fitness_unit))}
        if drawn
        else {}
    )


ROBUSTNESS_GEAR = Study(
    name="robustness-gear",
    summary="the design found for Ant-Powered, trained with motors of gear 50 to 300",
    arms=(Arm("robomore"),),
    tables=_tables,
    figures=_figures,
    tasks=tuple(f"ant-powered-{gear}" for gear in reversed(GEARS)),
    searched="ant-powered",
)

ROBUSTNESS_TERRAIN = Study(
    name="robustness-terrain",
    summary="the design found for Ant-Desert, trained on flat ground, snow and hills",
    arms=(Arm("robomore"),),
    tables=_tables,
    figures=_figures,
    tasks=("ant-ground", "ant-snow", "ant-hills"),
    searched="ant-desert",
)
