"""The found reward on the human design, and the found morphology under the reference reward."""

from __future__ import annotations

from statistics import fmean

from robomore.runs.words import unit_of
from robomore.studies.crossed import group_score
from robomore.studies.study import Arm, Results, Study
from robomore.studies.table import Entry, Table

PAIRS = {
    "found": "found morphology, found reward",
    "morphology_only": "found morphology, reference reward",
    "reward_only": "reference morphology, found reward",
    "reference": "reference morphology, reference reward",
}
"""Group of the final, and what it is."""


def _tables(results: Results) -> list[Table]:
    rows: list[tuple[Entry, ...]] = []
    for task in results.tasks:
        runs = results.runs(task)
        for name, pair in PAIRS.items():
            scores = [
                s for run in runs if (s := group_score(run, name, results.objective)) is not None
            ]
            wins = [run.champion_role == name for run in runs if run.final]
            rows.append(
                (
                    task,
                    pair,
                    fmean(scores) if scores else None,
                    min(scores, default=None),
                    max(scores, default=None),
                    f"{sum(wins)} of {len(wins)}",
                )
            )
    unit = unit_of(results.objective, results.fitness_unit) or "no unit"
    columns = ("task", "pair", f"mean ({unit})", f"lowest run ({unit})", f"highest run ({unit})")
    return [
        Table(
            "transfer",
            "Whether the morphology or the reward made the difference",
            (*columns, "champion"),
            tuple(rows),
            "Each pair of each run is trained anew with as many seeds.",
        )
    ]


TRANSFER = Study(
    name="transfer",
    summary="the found reward on the human design, and the found morphology under its reward",
    arms=(Arm("robomore"),),
    tables=_tables,
)
