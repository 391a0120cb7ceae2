"""How different first proposals are, in numbers, in words, and in how the robots move."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean

import numpy as np

from robomore.runs import Run
from robomore.runs.lineage import Record
from robomore.statistics import coefficient_of_variation, self_bleu
from robomore.statistics.diversity import tokens
from robomore.studies.study import PROPOSED, Arm, Results, Study
from robomore.studies.table import Entry, Table
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
            scores = [
                score
                for first in runs
                for record in first
                if (score := record.evaluation.score(results.objective)) is not None
            ]
            rows.append(
                (
                    task,
                    arm,
                    fmean(scores) if scores else None,
                    max(scores, default=None),
                    _mean([_variation(first) for first in runs]),
                    _mean([_self_bleu(first) for first in runs]),
                    _mean([_behaviour([r.evaluation for r in first], everyone) for first in runs]),
                    sum(map(len, runs)),
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
                    "Self-BLEU of rewards",
                    "spread of gaits",
                    "pairs",
                ),
            ),
            tuple(rows),
            "Every pair of the grid counts, and so does a proposal that repeats an earlier one. "
            "Variation: the standard deviation over the mean of each parameter, averaged; more is "
            "more diverse. Self-BLEU: what rewards share in words, comments left out; less is more "
            "diverse. Spread of gaits: the mean distance between two pairs in stride, amplitude, "
            "contact and speed, each divided by its standard deviation over all arms; more is more "
            "diverse.",
        )
    ]


def _first(run: Run) -> list[Record]:
    """Return the pairs of the grid, made from no other evaluation, one for each place of it."""
    return list({r.place.index: r for r in run.searched if not r.place.parent}.values())


def _variation(first: Sequence[Record]) -> float | None:
    rows = {r.place.index[0]: r.evaluation.design.morphology.parameters for r in first}
    return coefficient_of_variation(list(rows.values())) if len(rows) > 1 else None


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
