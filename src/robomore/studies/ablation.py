"""What each part of the paper's method is good for: the search without it, on the same budget.

Without the fine stage there is the grid alone, which needs less.
"""

from __future__ import annotations

from robomore.studies.aggregate import Bases, aggregate_table, interval_figure
from robomore.studies.scores import curve_figures, found_table
from robomore.studies.study import Arm, Draw, Results, Study
from robomore.studies.table import Table

FULL = "robomore"


_ON = {"max_cycles": 100, "patience": 100}
"""Refines for as long as the budget lasts: a smaller grid would leave most of it."""


def _without(part: str) -> Arm:
    on = _ON if part in ("coarse", "morphology", "reward") else {}
    return Arm(f"without-{part}", {"method_options": {"without": [part], **on}})


def _full(results: Results) -> Bases:
    """Return the runs of the whole method on each task."""
    return {task: results.answers(task, FULL) for task in results.tasks}


def _tables(results: Results) -> list[Table]:
    return [
        found_table(results),
        aggregate_table(results, "over-robomore", FULL, _full(results)),
    ]


def _figures(results: Results) -> dict[str, Draw]:
    return curve_figures(results) | interval_figure(results, _full(results), FULL)


ABLATION = Study(
    name="ablation",
    summary="robomore without one of its parts at a time",
    arms=(
        Arm(FULL),
        _without("diversity"),
        _without("morphology"),
        _without("reward"),
        Arm("without-reference-reward", {"method_options": {"reference_reward": "out"}}),
        Arm("without-slim-reference", {"method_options": {"slim_reference": "out"}}),
        Arm("without-adaptive-order", {"method_options": {"order": "alternate"}}),
        Arm("without-screening", {"method_options": {"screening": "none"}}),
        Arm("reference", {"method": "reference"}),
    ),
    tables=_tables,
    figures=_figures,
    curves=True,
)

COARSE_TO_FINE = Study(
    name="coarse-to-fine",
    summary="robomore without the coarse stage, and without the fine one",
    arms=(Arm(FULL), _without("fine"), _without("coarse")),
    tables=_tables,
    figures=_figures,
    curves=True,
)
