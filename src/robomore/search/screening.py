"""Screening: training is spent on the pairs of the grid that deserve it.

Successive halving (Jamieson and Talwalkar 2016) with continued training: every pair is trained for
a first share of its steps, the best go on from where they stopped, and so on at each rung. Before
that, bodies that do badly under the reference reward can be given fewer rewards to try: a body that
no reward makes good was a third of the paper's grid.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from robomore.errors import InputError
from robomore.events import Cut, Observer
from robomore.search.measure import Evaluate, ranked
from robomore.settings import Rung, Screening
from robomore.types import Design, Evaluation, Place, Reward, Trial


def screened(
    evaluate: Evaluate,
    trials: Sequence[Trial],
    screening: Screening,
    reference: Reward,
    objective: str,
    observe: Observer,
) -> list[Evaluation]:
    """Return one evaluation for each pair that was tried, in the grid's order.

    Those that were cut have fewer steps than those that were not (`robomore.types.finished`).

    Args:
        evaluate: measures a batch at a share of the full budget, continuing what it trained before.
        trials: the grid, row by row.
        screening: where is cut, and how much.
        reference: reward under which bodies are compared.
        objective: `efficiency` or `fitness`.
        observe: told who is cut, and why.

    Raises:
        InputError: the rungs make no sense.
    """
    check(screening)
    racing = list(trials)
    if screening.prefilter_fraction > 0 and racing:
        racing = _without_hopeless(evaluate, racing, screening, reference, objective, observe)
    latest: dict[Place, Evaluation] = {}
    for rung in screening.rungs:
        measured = evaluate(racing, share=rung.share)
        latest |= {trial.place: e for trial, e in zip(racing, measured, strict=True)}
        racing = _best(racing, measured, rung, len(trials), objective, observe)
    measured = evaluate(racing, share=1.0)
    latest |= {trial.place: e for trial, e in zip(racing, measured, strict=True)}
    return [latest[trial.place] for trial in trials if trial.place in latest]


def check(screening: Screening) -> None:
    """Refuse rungs that make no sense.

    Raises:
        InputError: naming the rung, the range and the remedy.
    """
    for rung in screening.rungs:
        if not (0 < rung.share < 1 and 0 < rung.kept <= 1):
            raise InputError(f"{rung}: share has to be in (0, 1) and kept in (0, 1]")
    for first, second in pairwise(screening.rungs):
        if not (first.share < second.share and first.kept >= second.kept):
            raise InputError(
                f"{second} comes after {first}: the share of training has to rise from rung to "
                "rung, and the share that is kept must not"
            )
    if not 0 <= screening.prefilter_fraction < 1 or screening.prefiltered_rewards < 0:
        raise InputError(
            f"prefilter_fraction = {screening.prefilter_fraction} has to be in [0, 1), prefiltered_rewards = "
            f"{screening.prefiltered_rewards} at least 0"
        )


def _best(
    racing: list[Trial],
    measured: list[Evaluation],
    rung: Rung,
    pairs: int,
    objective: str,
    observe: Observer,
) -> list[Trial]:
    """Return those that go on from `rung`, in the grid's order."""
    order = ranked(measured, objective)
    kept = {e.key for e in order[: max(1, math.floor(rung.kept * pairs + 0.5))]}
    places = {e.key: number for number, e in enumerate(order, start=1)}
    for trial, evaluation in zip(racing, measured, strict=True):
        if evaluation.key in kept:
            continue
        score = evaluation.score(objective)
        reason = (
            f"{evaluation.status} after {evaluation.job.steps} steps"
            if score is None
            else f"{objective} {score:.4g} after {evaluation.job.steps} steps is number "
            f"{places[evaluation.key]} of {len(racing)}, and {len(kept)} go on"
        )
        observe(Cut(trial.place, evaluation.job.steps, reason))
    return [t for t, e in zip(racing, measured, strict=True) if e.key in kept]


def _without_hopeless(
    evaluate: Evaluate,
    trials: list[Trial],
    screening: Screening,
    reference: Reward,
    objective: str,
    observe: Observer,
) -> list[Trial]:
    """Return `trials` without most of those of the bodies that do worst under `reference`."""
    bodies = {trial.place.morphology: trial.design.morphology for trial in trials}
    share = screening.rungs[0].share if screening.rungs else 1.0
    first_look = evaluate(
        [
            Trial(Design(body, reference), Place(stage="screening", morphology=row))
            for row, body in bodies.items()
        ],
        share=share,
    )
    rows = {e.key: row for row, e in zip(bodies, first_look, strict=True)}
    order = [rows[e.key] for e in ranked(first_look, objective)]
    standing = {row: number for number, row in enumerate(order, start=1)}
    promising = set(order[: max(1, math.ceil((1 - screening.prefilter_fraction) * len(bodies)))])
    # The first ones proposed; a column can be empty.
    first = sorted({trial.place.reward for trial in trials})[: screening.prefiltered_rewards]
    going_on = []
    for trial in trials:
        row = trial.place.morphology
        if row in promising or trial.place.reward in first:
            going_on.append(trial)
            continue
        number = f"number {standing[row]}" if row in standing else "one that failed"
        reason = f"its body is {number} of {len(bodies)} under the reference reward"
        observe(Cut(trial.place, 0, reason))
    return going_on
