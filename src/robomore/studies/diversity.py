"""How different first proposals are, in numbers, in words, and in how the robots move."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean, stdev

import numpy as np

from robomore.runs import Run
from robomore.runs.lineage import Record
from robomore.statistics import coefficient_of_variation, self_bleu
from robomore.statistics.diversity import tokens
from robomore.studies.study import PROPOSED, Arm, Results, Study
from robomore.studies.table import Entry, Table
from robomore.tasks import Task
from robomore.types import Evaluation

GAIT = ("stride_frequency_hz", "joint_amplitude_rad", "ground_contact_share", "forward_speed_m_s")
"""Measures of a way to move, none of which is the score itself."""


def _tables(results: Results) -> list[Table]:
    rows: list[tuple[Entry, ...]] = []
    for task in results.tasks:
        # One ruler for all arms: how far a measure spreads over everything that was trained.
        everyone = [r.evaluation for run in results.runs(task) for r in _first(run)]
        for arm in results.arms:
            runs = [first for run in results.runs(task, arm) if (first := _first(run))]
            asked = [record.evaluation for first in runs for record in first]
            scores = [s for one in asked if (s := one.score(results.objective)) is not None]
            rows.append(
                (
                    task,
                    arm,
                    fmean(scores) if scores else None,
                    max(scores, default=None),
                    _mean([_variation(first) for first in runs]),
                    _mean([_deviation(run.task, _first(run)) for run in results.runs(task, arm)]),
                    _mean([_self_bleu(first) for first in runs]),
                    _mean([_behaviour([r.evaluation for r in first], everyone) for first in runs]),
                    f"{len(scores)} of {len(asked)}",
                )
            )
    return [
        Table(
            "diversity",
            f"First proposals, each trained once: {results.objective} and diversity",
            (
                *("task", "arm", f"mean {results.objective}", f"highest {results.objective}"),
                *(
                    "variation of morphologies",
                    "deviation over the search range",
                    "Self-BLEU of rewards",
                    "spread of gaits",
                    "pairs",
                ),
            ),
            tuple(rows),
            "Pairs: those that trained, of all that were tried; pairs that failed are in neither "
            f"the mean {results.objective} nor the gaits, so that an arm with many of them looks "
            "better than it is. A proposal that repeats an earlier one counts. Variation, the "
            "paper's measure: the standard deviation over the mean of each parameter, averaged; "
            "more is more diverse, but a coordinate whose mean is near 0 decides it alone. "
            "Deviation over the search range: the standard deviation of each parameter as a "
            "share of its search range, averaged; more is more diverse, and draws that are uniform "
            "over the range have 0.29. Self-BLEU: what rewards share in words, comments left out; "
            "less is more diverse. Spread of gaits: the mean distance between two pairs in stride, "
            "amplitude, contact and speed, each divided by its standard deviation over all arms; "
            "more is more diverse.",
        )
    ]


def _first(run: Run) -> list[Record]:
    """Return the pairs of the grid, made from no other evaluation, one for each place of it."""
    return list({r.place.index: r for r in run.searched if not r.place.parent}.values())


def _variation(first: Sequence[Record]) -> float | None:
    rows = _morphologies(first)
    return coefficient_of_variation(rows) if len(rows) > 1 else None


def _deviation(task: Task, first: Sequence[Record]) -> float | None:
    """Return the standard deviation of each parameter over its search range, averaged.

    A plain share of the range, which counts a proposal beyond it as far as it goes: a logarithm has
    no place for the negative coordinates and the lengths of 0 that some tasks allow there.
    """
    rows = _morphologies(first)
    if len(rows) < 2:
        return None
    widths = [parameter.high - parameter.low for parameter in task.searched().parameters]
    columns = zip(*rows, strict=True)
    return fmean(stdev(column) / width for column, width in zip(columns, widths, strict=True))


def _morphologies(first: Sequence[Record]) -> list[tuple[float, ...]]:
    return list(
        {r.place.index[0]: r.evaluation.design.morphology.parameters for r in first}.values()
    )


def _self_bleu(first: Sequence[Record]) -> float | None:
    columns = {r.place.index[1]: r.evaluation.design.reward.source for r in first}
    texts = [tokens(text) for text in columns.values()]
    return self_bleu(texts) if len(texts) > 1 else None


def _behaviour(first: Sequence[Evaluation], everyone: Sequence[Evaluation]) -> float | None:
    ruler = _gaits(everyone)
    mine = _gaits(first)
    if len(mine) < 2:
        return None
    deviation = ruler.std(axis=0)
    scaled = mine[:, deviation > 0] / deviation[deviation > 0]
    apart = np.sqrt(((scaled[:, None] - scaled[None]) ** 2).sum(axis=2))
    return float(apart[np.triu_indices(len(mine), 1)].mean())


def _gaits(evaluations: Sequence[Evaluation]) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    rows = [
        [e.behaviour[name] for name in GAIT]
        for e in evaluations
        if e.ok and all(name in e.behaviour for name in GAIT)
    ]
    return np.array(rows, dtype=float).reshape(-1, len(GAIT))


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return fmean(known) if known else None


RANDOM = Arm("random", {"method_options": {"without": ["fine"], "first_morphologies": "gaussian"}})
"""The paper's Random Sample: random morphologies in the same grid, under the same rewards."""

DIVERSITY = Study(
    name="diversity",
    summary="first proposals with and without Diversity Reflection, and random ones",
    arms=(
        RANDOM,
        Arm("without-diversity", {"method_options": {"without": ["diversity", "fine"]}}),
        Arm("with-diversity", {"method_options": {"without": ["fine"]}}),
    ),
    tables=_tables,
    change=PROPOSED,
    whole_grid=True,
)
