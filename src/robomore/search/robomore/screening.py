"""Screening: training is spent on the pairs of the grid that deserve it.

Successive halving (Jamieson and Talwalkar 2016) with continued training: every pair is trained for
a first fraction of its steps, the best go on from where they stopped, and so on at each rung.
Before that, morphologies that do badly under the reference reward can be given fewer rewards to
try, on request: it cost more good pairs than it saved steps (benchmarks/README.md).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from robomore.events import Cut
from robomore.search.measure import Evaluate, ranked, survivor_count
from robomore.search.method import SearchContext
from robomore.search.robomore.planning import COARSE, SCREENING
from robomore.search.robomore.settings import RoboMoReSettings, Rung
from robomore.types import Design, Evaluation, Place, Trial


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
        context: the reference reward, under which morphologies are compared, and the objective.
    """
    racing = list(trials)
    if settings.prefilter_fraction > 0 and racing:
        racing = _prefiltered(evaluate, racing, settings, context)
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


def _prefiltered(
    evaluate: Evaluate,
    trials: list[Trial],
    settings: RoboMoReSettings,
    context: SearchContext,
) -> list[Trial]:
    """Return `trials` without most of those of the morphologies that do worst in a first look."""
    in_grid = settings.reference_reward == "in"
    rows = {trial.place.index[0]: trial.design.morphology for trial in trials}
    looks = []
    for row, morphology in rows.items():
        # The reference column is trained anyway, and goes on from here.
        place = Place(stage=COARSE, index=(row, 0))
        if not in_grid:
            place = Place(stage=SCREENING, index=(row,))
        looks.append(Trial(Design(morphology, context.reference.reward), place))
    fraction = settings.rungs[0].budget_fraction if settings.rungs else 1.0
    measured = evaluate(looks, budget_fraction=fraction)
    row_of = {e.key: row for row, e in zip(rows, measured, strict=True)}
    order = [row_of[e.key] for e in ranked(measured, context.objective)]
    standing = {row: number for number, row in enumerate(order, start=1)}
    count = max(1, math.ceil((1 - settings.prefilter_fraction) * len(rows)))
    promising = set(order[:count])
    # The first ones proposed; a column can be empty.
    columns = sorted({trial.place.index[1] for trial in trials})
    few = {0} if in_grid else set()
    few |= set([c for c in columns if c not in few][: settings.prefiltered_rewards])
    going_on = []
    for trial in trials:
        row, column = trial.place.index
        if row in promising or column in few:
            going_on.append(trial)
            continue
        number = f"number {standing[row]}" if row in standing else "one that failed"
        reason = f"its morphology is {number} of {len(rows)} under the reference reward"
        context.observe(Cut(trial.place, 0, reason))
    return going_on
