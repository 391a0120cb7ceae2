"""Which design of a run is meant: the champion, the reference, or any evaluation."""

from __future__ import annotations

from robomore.errors import InputError
from robomore.runs import Run, TrainedDesign
from robomore.runs.trained import trained_design


def selected(run: Run, evaluation: str | None = None, reference: bool = False) -> TrainedDesign:
    """Return the champion of a run, or what is asked for instead.

    Args:
        run: a run, finished or not.
        evaluation: key of one of its evaluations, or the beginning of one that fits no other.
        reference: the reference design of the run's final.

    Raises:
        InputError: there is no such design.
    """
    if evaluation is not None and reference:
        raise InputError("give --evaluation or --reference, not both")
    if evaluation is not None:
        return trained_design(evaluation, run.task, [run.evaluation(evaluation)])
    if reference:
        if run.reference is None:
            raise InputError(f"{run.folder} has no final yet, so no reference design; run it on")
        return run.reference
    if run.champion is None:
        raise InputError(f"{run.folder} has nothing trained yet; wait, or run it on")
    return run.champion
