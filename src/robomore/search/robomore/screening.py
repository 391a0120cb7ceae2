"""Screening: training is spent on the pairs of the grid that deserve it.

Successive halving (Jamieson and Talwalkar 2016) with continued training: every pair is trained for
a first fraction of its steps, the best go on from where they stopped, and so on at each rung.
"""

from __future__ import annotations

from collections.abc import Sequence

from robomore.events import Cut
from robomore.search.measure import Evaluate, ranked, survivor_count
from robomore.search.method import SearchContext
from robomore.search.robomore.settings import RoboMoReSettings, Rung
from robomore.types import Evaluation, Place, Trial


def screened(
    evaluate: Evaluate,
    trials: Sequence[Trial],
    settings: RoboMoReSettings,
    context: SearchContext,
) -> list[Evaluation]:
    """Return one evaluation for each pair that was tried, in the grid's order.

    Those that were cut have fewer steps than those that were not (`robomore.types.finished`).

    Args:
        evaluate: measures a batch at a fraction of the full budget, continuing what it trained.
        trials: the grid, row by row.
        settings: where is cut, and how much.
        context: the objective, and who is told of each cut.
    """
    racing = list(trials)
    latest: dict[Place, Evaluation] = {}
    for rung in settings.rungs:
        measured = evaluate(racing, budget_fraction=rung.budget_fraction)
        latest |= {trial.place: e for trial, e in zip(racing, measured, strict=True)}
        racing = _best(racing, measured, rung, len(trials), context)
    measured = evaluate(racing, budget_fraction=1.0)
    latest |= {trial.place: e for trial, e in zip(racing, measured, strict=True)}
    return [latest[trial.place] for trial in trials if trial.place in latest]


def _best(
    racing: list[Trial],
    measured: list[Evaluation],
    rung: Rung,
    pairs: int,
    context: SearchContext,
) -> list[Trial]:
    """Return those that go on from `rung`, in the grid's order."""
    order = ranked(measured, context.objective)
    kept = {e.key for e in order[: survivor_count(rung.keep_fraction, pairs)]}
    places = {e.key: number for number, e in enumerate(order, start=1)}
    for trial, evaluation in zip(racing, measured, strict=True):
        if evaluation.key in kept:
            continue
        score = evaluation.score(context.objective)
        reason = (
            f"{evaluation.status} after {evaluation.job.steps} steps"
            if score is None
            else f"{context.objective} {score:.4g} after {evaluation.job.steps} steps is number "
            f"{places[evaluation.key]} of {len(racing)}, and {len(kept)} go on"
        )
        context.observe(Cut(trial.place, evaluation.job.steps, reason))
    return [t for t, e in zip(racing, measured, strict=True) if e.key in kept]
