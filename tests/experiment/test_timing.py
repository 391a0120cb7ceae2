"""No result depends on timing: on which worker is quick, and on which answer comes first."""

from __future__ import annotations

import random
from collections.abc import Callable, Generator, Sequence
from pathlib import Path

import pytest

from exhaustive import more_of
from robomore.events import ignore
from robomore.executors import Outcome
from robomore.executors.executor import Progress, never
from robomore.experiment import run
from robomore.options import with_options
from robomore.search import METHODS
from robomore.settings import preset
from robomore.studies import Arm, Study
from robomore.studies.execute import cells_of, run_study
from robomore.studies.presets import Scale
from tiny import numbers
from untrained import Untrained

SMALL = with_options(preset("smoke"), evaluations=8, trainer_options={"learning_starts": 256})
SCREENED = {"morphologies": 6, "rewards": 3, "screening": "halving", "max_cycles": 3}


class Shuffled(Untrained):
    """Takes jobs in any order and answers in any other, as a cluster with a slow machine does."""

    def __init__(self, seed: int) -> None:
        super().__init__(workers=5)
        self._random = random.Random(seed)

    def map(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Progress,
        timeout: float,
        should_stop: Callable[[], bool] = never,
    ) -> Generator[tuple[int, Outcome]]:
        order = list(range(len(payloads)))
        self._random.shuffle(order)
        mixed = [payloads[index] for index in order]
        answers = list(super().map(function, mixed, lambda n, units: None, timeout, should_stop))
        for index in order:
            progress(index, 0)
        self._random.shuffle(answers)
        for place, outcome in answers:
            yield order[place], outcome


@pytest.mark.parametrize(
    "method",
    more_of([n for n in METHODS if n != "reference"], "robomore", "cmaes", "eureka-morphology"),
)
def test_a_method_finds_the_same_whatever_the_order_of_answers(method: str, tmp_path: Path) -> None:
    options = SCREENED if method == "robomore" else {}
    settings = with_options(SMALL, method=method, method_options=options)
    found = []
    for name, executor in (("plain", Untrained(1)), ("mixed", Shuffled(7))):
        done = run("swimmer", settings, executor=executor, out=tmp_path / name, seed=3)
        assert done.champion is not None
        found.append((numbers(tmp_path / name), done.champion.design))
    assert found[0] == found[1]
    assert len(found[0][0]) > 4


def test_cells_side_by_side_are_the_cells_one_by_one(tmp_path: Path) -> None:
    arms = (Arm("robomore"), Arm("random", {"method": "random"}), Arm("cmaes", {"method": "cmaes"}))
    cells = cells_of(Study("three", "", arms, lambda results: []), ["swimmer"], Scale(SMALL, 2), 2)
    study = Study("three", "", arms, lambda results: [])
    for name, many in (("one", 1), ("many", 4)):
        results = run_study(
            study,
            cells,
            tmp_path / name,
            executor=Shuffled(many),
            side_by_side=many,
            tell=lambda index, cell: ignore,
        )
        assert [cell for cell, _ in results.cells] == cells
    for cell in cells:
        assert numbers(tmp_path / "one" / cell.folder) == numbers(tmp_path / "many" / cell.folder)
