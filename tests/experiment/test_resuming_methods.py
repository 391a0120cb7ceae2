"""Whatever the method, a run that dies over and over ends as if it never had."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import untrained  # noqa: F401  # makes its executor known
from exhaustive import more_of
from robomore.events import Event, Finished
from robomore.experiment import run
from robomore.options import with_options
from robomore.runs import load_run
from robomore.search import METHODS
from robomore.settings import preset
from tiny import numbers

SIZES: dict[str, dict[str, Any]] = {
    "robomore": {},
    "random": {},
    "reference": {},
    "slim-reference": {"values": 4},
    "eureka": {"iterations": 2, "samples": 2},
    "eureka-morphology": {"iterations": 2, "samples": 2},
    "bayesian": {"evaluations": 6, "initial": 3, "batch": 1},
    "cmaes": {"evaluations": 8, "population": 4},
    "genetic": {"evaluations": 9, "population": 3},
    "map-elites": {},
    "given": {},
}
"""Small, but with more than one round where a method has rounds."""
LIFE = 2
"""Evaluations that each life finishes."""


class Killed(BaseException):
    """Nothing catches it: all that is left is what lies in the folder."""


def start(method: str, out: Path, life: int | None) -> None:
    finished = 0

    def observe(event: Event) -> None:
        nonlocal finished
        finished += isinstance(event, Finished) and not event.known
        if life is not None and finished >= life:
            raise Killed

    settings = with_options(
        preset("smoke"), method=method, method_options=SIZES[method], evaluations=8
    )
    run("swimmer", settings, seed=3, executor="untrained", out=out, observe=observe)


def test_all_methods_are_tried() -> None:
    assert set(SIZES) >= set(METHODS.names())


@pytest.mark.parametrize("method", more_of(SIZES, "robomore", "bayesian", "eureka"))
def test_a_run_that_dies_again_and_again_ends_the_same(method: str, tmp_path: Path) -> None:
    start(method, tmp_path / "whole", None)
    deaths = 0
    while True:
        try:
            start(method, tmp_path / "killed", LIFE)
        except Killed:
            deaths += 1
            continue
        break
    whole, killed = load_run(tmp_path / "whole"), load_run(tmp_path / "killed")
    assert deaths >= len(whole.evaluations) // LIFE - 1
    assert numbers(tmp_path / "killed") == numbers(tmp_path / "whole")
    assert [p.slot for p in killed.proposals] == [p.slot for p in whole.proposals]
    assert killed.champion == whole.champion and killed.champion_role == whole.champion_role
    assert [r.place for r in killed.lineage] == [r.place for r in whole.lineage]
