"""The Pareto set of a run, and what it covers relative to the reference."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import pytest

from robomore.runs.lineage import Record
from robomore.runs.pareto import covered, in_words, pareto_set
from robomore.types import Design, Evaluation, Morphology, Place, Reward, Status
from test_types import MOVED


def design(key: str, fitness: float, volume: float, energy: float | None) -> Evaluation:
    moved = {} if energy is None else {"energy_j": energy}
    own = Design(Morphology((float(sum(map(ord, key.partition("-")[0]))),)), Reward(""))
    job = replace(MOVED.job, design=own)
    return replace(MOVED, key=key, job=job, fitness=fitness, volume=volume, behaviour=moved)


@dataclass
class Searched:
    searched: list[Record]
    reference: Any


def run_of(*evaluations: Evaluation) -> Any:
    records = [Record(Place(stage="samples"), one) for one in evaluations]

    class Reference:
        trained = (design("r", 10.0, 1.0, 100.0), design("s", 10.0, 1.0, 300.0))

    return Searched(records, Reference())


def test_who_is_beaten_by_nobody_stays() -> None:
    fast = design("fast", 20.0, 0.5, 150.0)
    small = design("small", 5.0, 0.1, 100.0)
    worse = design("worse", 4.0, 0.2, 120.0)
    unknown = design("unknown", 50.0, 0.1, None)
    failed = replace(design("failed", 90.0, 0.1, 1.0), status=Status.UNSTABLE)
    run = run_of(small, worse, fast, unknown, failed, small)
    assert [e.key for e in pareto_set(run)] == ["fast", "small"]


def test_a_design_counts_once_by_the_mean_of_its_seeds() -> None:
    lucky = [design("a-1", 30.0, 0.5, 80.0), design("a-2", 10.0, 0.5, 120.0)]
    steady = design("b", 25.0, 0.5, 100.0)
    assert [e.key for e in pareto_set(run_of(*lucky))] == ["a-1"]
    assert covered(run_of(*lucky)) == pytest.approx(2 * 0.5 * 0.5)
    # Its luckier seed alone would stand beside the other design.
    assert [e.key for e in pareto_set(run_of(*lucky, steady))] == ["b"]


def test_what_is_covered_is_relative_to_the_reference() -> None:
    # Twice the fitness, half the volume, half the energy of the reference (10 m, 1 m^3, 200 J).
    assert covered(run_of(design("a", 20.0, 0.5, 100.0))) == pytest.approx(2 * 0.5 * 0.5)
    assert covered(run_of(design("larger", 20.0, 2.0, 100.0))) == 0
    assert covered(Searched([], None)) is None  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("designs", "expected"),
    [
        ([], "0 designs"),
        ([design("larger", 20.0, 2.0, 100.0)], "1 design; none gets forward with both less"),
        ([design("a", 20.0, 0.5, 100.0)], "1 design"),
        (
            [design("a", 20.0, 0.5, 100.0), design("b", 10.0, 0.25, 100.0)],
            "2 designs, hypervolume 0.6250: what",
        ),
    ],
)
def test_what_is_covered_is_told_where_it_says_something(
    designs: list[Evaluation], expected: str
) -> None:
    run = run_of(*designs)
    run.pareto_set, run.hypervolume = pareto_set(run), covered(run)
    said = in_words(run)
    assert said.startswith(expected)
    assert ("hypervolume" in said) == ("hypervolume" in expected)
