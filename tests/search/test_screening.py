"""Screening on numbers: who is trained how long, who is cut and what is said of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest

from robomore.errors import InputError, NothingTrained
from robomore.events import Cut, Event
from robomore.search.robomore import RoboMoRe, RoboMoReSettings, Rung
from robomore.settings import from_options
from robomore.types import Design, Evaluation, Morphology, Trial, finished
from search.fakes import (
    REFERENCE,
    STEPS,
    CountingDesigner,
    Measuring,
    evaluation,
    numbers,
    robomore,
    sizes,
)

SETTINGS = sizes(
    4,
    2,
    survivors=0.25,
    max_cycles=0,
    screening="halving",
    rungs=(Rung(0.1, 0.5), Rung(0.5, 0.25)),
)


class Partial(Measuring):
    """Scores grow with the share of training; `early` says by how much they mislead."""

    def __init__(self, early: float = 0.0, broken: tuple[float, float] | None = None) -> None:
        super().__init__(lambda body, reward: body * reward)
        self.early, self.broken = early, broken
        self.shares: list[float] = []

    def __call__(
        self, trials: Sequence[Trial], *, budget_fraction: float = 1.0
    ) -> list[Evaluation]:
        self.batches.append(list(trials))
        share = budget_fraction
        self.shares.append(share)
        found = []
        for trial in trials:
            body, reward = numbers(trial.design)
            fails = (body, reward) == self.broken
            score = None if fails else share * body * reward - (1 - share) * self.early * body
            one = evaluation(trial.design, score)
            job = replace(one.job, steps=round(share * STEPS))
            found.append(replace(one, job=job, key=f"{one.key}-{share}"))
        return found


def grid(measuring: Measuring) -> list[list[tuple[float, float]]]:
    return [[numbers(trial.design) for trial in batch] for batch in measuring.batches]


def search(measuring: Measuring, settings: RoboMoReSettings = SETTINGS) -> tuple[list[float], list]:
    told: list[Event] = []
    best = robomore(CountingDesigner(), measuring, settings, told.append)
    return [e.efficiency or 0.0 for e in best], told


def test_the_best_go_on_from_rung_to_rung() -> None:
    measuring = Partial()
    best, _ = search(measuring)
    assert measuring.shares == [0.1, 0.5, 1.0]
    pairs, half, quarter = grid(measuring)
    assert pairs == [(b, r) for b in (1, 2, 3, 4) for r in (10, 20)]
    assert half == [(2, 20), (3, 20), (4, 10), (4, 20)]
    assert quarter == [(3, 20), (4, 20)]
    assert best == [80.0, 60.0]


def test_what_was_cut_is_never_the_answer() -> None:
    # After a tenth of the training the worst pairs look best.
    best, _ = search(Partial(early=10.0))
    exhaustive, _ = search(Partial(early=10.0), replace(SETTINGS, screening="none"))
    assert exhaustive == [80.0, 60.0]
    assert best == [40.0, 20.0]
    # And here what was cut looked better than anything that was trained to the end.
    best, _ = search(Partial(early=-100.0))
    assert best == [80.0, 40.0]


def test_it_is_said_who_was_cut_when_and_why() -> None:
    _, told = search(Partial(broken=(2, 20)))
    cuts = [event for event in told if isinstance(event, Cut)]
    assert [(*c.place.index, c.steps) for c in cuts] == [
        *((0, 0, 100), (0, 1, 100), (1, 0, 100), (1, 1, 100)),
        *((2, 0, 500), (3, 0, 500)),
    ]
    assert cuts[0].reason == "efficiency 1 after 100 steps is number 7 of 8, and 4 go on"
    assert cuts[3].reason == "reward-failed after 100 steps"


def test_a_designer_sees_what_was_cut_short_and_branches_start_from_the_rest() -> None:
    designer = CountingDesigner()
    settings = replace(SETTINGS, max_cycles=1)
    robomore(designer, Partial(), settings)
    (first, *_) = designer.histories
    assert [key.rsplit("-")[-1] for key in first] == [
        *("0.1", "0.1", "0.1", "0.5", "0.1", "1.0", "0.5", "1.0"),
    ]


def test_the_share_of_survivors_is_of_the_whole_grid() -> None:
    best, _ = search(Partial(), replace(SETTINGS, survivors=0.125))
    assert best == [80.0]


def test_only_what_was_trained_alike_is_compared_and_failures_are_told() -> None:
    def trained(score: float | None, steps: int) -> Evaluation:
        one = evaluation(Design(Morphology((1.0,)), REFERENCE), score)
        return replace(one, job=replace(one.job, steps=steps))

    failed, short, long = trained(None, 10), trained(1.0, 10), trained(1.0, 20)
    assert finished([]) == []
    assert finished([failed, short, long]) == [failed, long]
    late = trained(None, 20)
    assert finished([failed, short, late]) == [failed, short, late], "one late failure ruins none"


def test_a_screened_grid_of_failures_says_why() -> None:
    measuring = Measuring(lambda body, reward: None)
    with pytest.raises(NothingTrained, match=r"all 8 candidates failed \(8 reward-failed\)"):
        search(measuring)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"rungs": [{"budget_fraction": 0.0, "keep_fraction": 0.5}]}, "budget_fraction"),
        ({"rungs": [{"budget_fraction": 1.0, "keep_fraction": 0.5}]}, "budget_fraction"),
        ({"rungs": [{"budget_fraction": 0.5, "keep_fraction": 0.0}]}, "keep_fraction"),
        ({"morphologies": 0}, "morphologies"),
        ({"screening": "halve"}, "halve"),
        ({"survivors": float("nan")}, "survivors = nan"),
        ({"rows": 3}, "no option 'rows'. It takes morphologies"),
    ],
)
def test_options_out_of_range_are_refused(options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        from_options(RoboMoReSettings, options, "method robomore")


@pytest.mark.parametrize(
    ("rungs", "said"),
    [
        ((Rung(0.5, 0.5), Rung(0.5, 0.1)), "has to rise"),
        ((Rung(0.2, 0.1), Rung(0.5, 0.5)), "must not"),
    ],
)
def test_rungs_that_make_no_sense_are_refused(rungs: tuple[Rung, ...], said: str) -> None:
    with pytest.raises(InputError, match=said):
        RoboMoRe(RoboMoReSettings(rungs=rungs))
