"""The paper's main table and more methods: all on one budget, and against the slimmed human."""

from __future__ import annotations

from robomore.search import METHODS
from robomore.studies.aggregate import Bases, aggregate_table, interval_figure
from robomore.studies.crossed import reward_table
from robomore.studies.retraining import GIVEN
from robomore.studies.scores import curve_figures, found_table
from robomore.studies.study import Arm, Draw, Results, Study
from robomore.studies.table import Table

SLIM = "slim-reference"

_BEGIN = ("bayesian", "cmaes", "eureka-morphology")
"""Methods that are run once more, from the slimmed human design."""


def _arms() -> tuple[Arm, ...]:
    """Return every method that searches, with and without the slimmed human design to begin with.

    The presets' own method keeps their options for it.
    """
    names = [name for name in METHODS if name != GIVEN]
    changes: dict[str, dict[str, object]] = {
        name: {} if name == "robomore" else {"method": name} for name in names
    }
    own = [Arm(name, change) for name, change in changes.items()]
    nothing = Arm("robomore-from-nothing", {"method_options": {"slim_reference": "out"}})
    # What a user would do who knows the slimmed human design, and `robomore` does by itself.
    begun = [Arm(f"{name}-from-{SLIM}", changes[name], start_from=(SLIM,)) for name in _BEGIN]
    return (*own, nothing, *begun)


def _slim(results: Results) -> Bases:
    return {task: results.answers(task, SLIM) for task in results.tasks}


def _tables(results: Results) -> list[Table]:
    human = {task: results.references(task) for task in results.tasks}
    return [
        found_table(results),
        aggregate_table(results, "over-human", "reference", human),
        aggregate_table(results, "over-slim", SLIM, _slim(results)),
        reward_table(results),
    ]


def _figures(results: Results) -> dict[str, Draw]:
    return curve_figures(results) | interval_figure(results, _slim(results), SLIM)


COMPARISON = Study(
    name="comparison",
    summary="every method on one budget, over the human and the slimmed human design",
    arms=_arms(),
    tables=_tables,
    figures=_figures,
    tasks=("swimmer", "half-cheetah"),
    curves=True,
)
