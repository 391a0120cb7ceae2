"""The final: everybody alike over seeds, crossed pairs, and the best of them all as champion."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from robomore.search import Final, final
from robomore.search.final import Group, stage
from robomore.settings import FinalSettings
from robomore.types import Design, Morphology, Reward
from search.fakes import Measuring, evaluation, numbers

REFERENCE = Design(Morphology((7.0,)), Reward("1.0"))


def play(
    score: Callable[[float, float], float | None],
    finalists: int = 1,
    seeds: int = 2,
    doubt: Callable[[Group], str] = lambda group: "",
) -> tuple[Final, Measuring]:
    measuring = Measuring(score)
    found = [evaluation(Design(Morphology((n,)), Reward("5.0")), 9.0) for n in (1.0, 2.0)]
    result = final(measuring, found[:finalists], REFERENCE, seeds, "efficiency", doubt=doubt)
    return result, measuring


def pair(group: tuple) -> tuple[float, float]:  # type: ignore[type-arg]
    return numbers(group[0].design)


def test_one_finalist_is_measured_with_its_crossed_pairs_in_one_batch() -> None:
    result, measuring = play(lambda morphology, reward: reward / morphology)
    (batch,) = measuring.batches
    assert [(numbers(t.design), t.place.repeat) for t in batch] == [
        (where, repeat)
        for where in ((1.0, 5.0), (7.0, 1.0), (1.0, 1.0), (7.0, 5.0))
        for repeat in (1, 2)
    ]
    assert pair(result.champion) == pair(result.found) == (1.0, 5.0)
    assert pair(result.morphology_only) == (1.0, 1.0)
    assert pair(result.reward_only) == (7.0, 5.0)
    assert pair(result.reference) == (7.0, 1.0)
    planned = stage(FinalSettings(steps=10, seeds=2))
    assert len(batch) == planned.evaluations and planned.batches == 1


def test_of_two_finalists_the_better_one_is_crossed() -> None:
    result, measuring = play(lambda morphology, reward: morphology * reward, finalists=2)
    first, second = measuring.batches
    assert [t.place.index for t in first if t.place.changed == "found"] == [(0,), (0,), (1,), (1,)]
    assert {numbers(t.design) for t in second} == {(2.0, 1.0), (7.0, 5.0)}
    assert len(first) + len(second) == stage(FinalSettings(10, finalists=2, seeds=2)).evaluations
    assert pair(result.found) == (2.0, 5.0)
    assert pair(result.champion) == (7.0, 5.0), "the reference morphology does better here"


@pytest.mark.parametrize(
    ("score", "champion"),
    [
        (lambda m, r: 1 / (m * r), (1.0, 1.0)),
        (lambda m, r: m * r, (7.0, 5.0)),
        (lambda m, r: m / r, (7.0, 1.0)),
        (lambda m, r: r / m, (1.0, 5.0)),
        (lambda m, r: 1.0, (1.0, 5.0)),
    ],
    ids=["found morphology", "found reward", "reference", "found pair", "equal"],
)
def test_the_best_pair_is_champion_whoever_proposed_it(
    score: Callable[[float, float], float], champion: tuple[float, float]
) -> None:
    result, _ = play(score)
    assert pair(result.champion) == champion


def test_a_design_that_failed_on_some_seeds_stands_behind_those_that_did_not() -> None:
    values = iter([100.0, None, 3.0, 4.0, 2.0, 2.0, 1.0, 1.0])
    result, _ = play(lambda morphology, reward: next(values))
    assert pair(result.champion) == (7.0, 1.0)
    assert [e.efficiency for e in result.champion] == [3.0, 4.0]


def test_the_reference_as_finalist_is_compared_with_itself() -> None:
    measuring = Measuring(lambda morphology, reward: 1.0)
    found = evaluation(REFERENCE, 1.0)
    result = final(measuring, [found], REFERENCE, 2, "efficiency")
    groups = (result.found, result.reference, result.morphology_only, result.reward_only)
    assert {pair(group) for group in groups} == {(7.0, 1.0)}


def test_a_finalist_that_fails_its_audit_is_passed_over_with_its_reason() -> None:
    def doubt(group: Group) -> str:
        return "energy: from nowhere" if pair(group)[0] == 2.0 else ""

    result, _ = play(lambda morphology, reward: morphology * reward, 2, doubt=doubt)
    assert pair(result.found) == (1.0, 5.0) and pair(result.morphology_only) == (1.0, 1.0)
    (over,) = result.passed_over
    assert pair(over[0]) == (2.0, 5.0) and over[1] == "energy: from nowhere"


def test_the_reference_is_champion_where_all_others_fail() -> None:
    asked: list[tuple[float, float]] = []

    def doubt(group: Group) -> str:
        asked.append(pair(group))
        return "no"

    result, _ = play(lambda morphology, reward: reward / morphology, 2, doubt=doubt)
    assert pair(result.champion) == pair(result.reference) == (7.0, 1.0)
    assert pair(result.found) == (1.0, 5.0), "the search's best is told all the same"
    assert len(asked) == len(set(asked)) == len(result.passed_over), "each is audited once"
    # A pair that trained on no seed has no seat, even where the reference is beyond the limits.
    result = final(
        Measuring(lambda body, reward: None if (body, reward) == (1.0, 1.0) else 1.0),
        [evaluation(Design(Morphology((1.0,)), Reward("5.0")), 9.0)],
        REFERENCE,
        2,
        "efficiency",
        lambda morphology: morphology.parameters != REFERENCE.morphology.parameters,
        lambda group: "no",
    )
    assert pair(result.champion) == (7.0, 1.0)
    # What is no better than the reference need not be audited.
    result, _ = play(lambda morphology, reward: morphology / reward, doubt=doubt)
    assert not result.passed_over
