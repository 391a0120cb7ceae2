"""The reference design with thinner radii, where a search has tried it: the first thing to beat.

Efficiency divides by the volume, so thin limbs pay before anything is invented.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from robomore.runs.lineage import best_of
from robomore.runs.words import in_unit, number
from robomore.tasks.task import Task
from robomore.tasks.unit_space import UnitSpace

if TYPE_CHECKING:
    from robomore.runs.run import Run

_SLIM = 0.95
"""Radii scaled by more than this are not slim."""
_ROUNDING = 1e-4
"""Difference in m between two scaled radii that is rounding."""


def slim_scale(task: Task, parameters: Sequence[float]) -> float | None:
    """Return by what all radii of the reference were scaled; `None` of any other morphology.

    Args:
        task: whose reference morphology it may be.
        parameters: of the morphology.
    """
    reference, found = np.array(task.reference), np.array(parameters)
    radii = UnitSpace(task).radii
    if not radii.any() or not np.array_equal(found[~radii], reference[~radii]):
        return None
    scale = float((found[radii] / reference[radii]).mean())
    if scale > _SLIM or np.abs(found[radii] - scale * reference[radii]).max() > _ROUNDING:
        return None
    return scale


def over_slimmed(run: Run) -> str:
    """Return what the search's best is over the slimmed reference design, as one sentence.

    Both were trained once, with the same budget. It is empty where the search has not tried the
    slimmed design, or found nothing better, or the run is not finished.
    """
    if not run.final or run.focus or run.is_smoke:
        return ""
    tried = [record.evaluation for record in run.searched]
    slim = [e for e in tried if slim_scale(run.task, e.design.morphology.parameters) is not None]
    best, beside = best_of(tried, run.objective), best_of(slim, run.objective)
    if best is None or beside is None or best in slim:
        return ""
    above, below = best.score(run.objective), beside.score(run.objective)
    if above is None or below is None or below <= 0:
        return ""
    return (
        f"The search's best has {number(above / below, 3)} times the {run.objective} of the "
        f"slimmed reference design, which nobody had to invent: {number(above)} against "
        f"{in_unit(below, run.objective, run.fitness_unit)}, each trained once with "
        f"{run.manifest.settings.candidate.steps:,} control steps, so luck is part of it."
    )
