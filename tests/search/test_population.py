"""Methods that search morphologies under the reference reward: contract, rules, lineage."""

from __future__ import annotations

from dataclasses import replace

import cmaes
import numpy as np
import pytest

from robomore.experiment.limits import limited
from robomore.search import make_method
from robomore.search.genetic import limbs_of
from robomore.search.population import valid_point
from robomore.settings import preset
from robomore.tasks import TASKS, get_task
from robomore.tasks.unit_space import UnitSpace
from robomore.testing.methods import check_method
from robomore.types import MethodSettings, Reward
from search.fakes import Measuring, context_of, evaluation

METHODS = {
    "bayesian": {"initial": 3},
    "cmaes": {"population": 4},
    "genetic": {"population": 3},
    "map-elites": {"initial": 3, "batch": 2},
}


class Volumes(Measuring):
    """The thinner, the better: what efficiency rewards before anything else."""

    def __init__(self) -> None:
        super().__init__(lambda morphology, reward: None)

    def evaluation_of(self, design):  # type: ignore[no-untyped-def]
        volume = get_task("hopper").volume(design.morphology.parameters)
        return evaluation(design, 1 / volume)


@pytest.mark.parametrize("name", METHODS)
def test_it_keeps_the_contract(name: str) -> None:
    # Of random hoppers near the reference, one in ten passes the rules.
    settings = MethodSettings(name, METHODS[name])
    check_method(lambda: make_method(settings), get_task("hopper"), 5)


@pytest.mark.parametrize("name", METHODS)
def test_it_finds_better_than_the_reference_and_tells_what_from(name: str) -> None:
    measuring = Volumes()
    context = context_of("hopper", evaluations=16)
    best = make_method(MethodSettings(name, METHODS[name])).run(None, measuring, context)  # type: ignore[arg-type]
    trials = [trial for batch in measuring.batches for trial in batch]
    assert len(trials) == 16
    assert {trial.design.reward for trial in trials} == {context.reference.reward}
    thinner = get_task("hopper").volume(best[0].design.morphology.parameters)
    assert thinner < 0.7 * get_task("hopper").volume(get_task("hopper").reference)
    known = {e.key for e in best}
    assert all(t.place.parent in known for t in trials if t.place.parent)


def test_a_point_that_no_draw_makes_valid_is_pulled_to_a_valid_one() -> None:
    task = get_task("swimmer")
    space = UnitSpace(task)
    # Thin and short at once: the fluid does not allow it.
    values = valid_point(space, lambda: np.zeros(space.size), task.reference)
    assert task.check(values) == values
    assert task.volume(values) < 0.1 * task.volume(task.reference)


def test_cmaes_learns_from_what_was_trained_and_not_from_what_a_limit_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    swimmer = get_task("swimmer")
    tight = limited(swimmer, replace(preset("smoke"), max_volume=0.0053))
    told: list[np.ndarray] = []
    real = cmaes.CMA.tell

    def tell(self: cmaes.CMA, solutions: list[tuple[np.ndarray, float]]) -> None:
        told.extend(point for point, _ in solutions)
        real(self, solutions)

    monkeypatch.setattr(cmaes.CMA, "tell", tell)
    measuring = Measuring(lambda morphology, reward: morphology)
    context = replace(context_of("swimmer", 24), task=tight)
    context = replace(context, reference=replace(context.reference, reward=Reward("1")))
    make_method(MethodSettings("cmaes", {"population": 4})).run(None, measuring, context)  # type: ignore[arg-type]
    space = UnitSpace(tight)
    trained = [t.design.morphology.parameters for batch in measuring.batches for t in batch]
    assert len(told) == len(trained) == 24
    assert np.abs(np.clip(told, 0, 1) - space.units(trained)).max() < 1e-3


@pytest.mark.parametrize("task", TASKS)
def test_limbs_hold_all_parameters_once(task: str) -> None:
    limbs = limbs_of(TASKS[task])
    assert sorted(index for limb in limbs for index in limb) == list(
        range(len(TASKS[task].parameters))
    )
    assert 1 < len(limbs) < len(TASKS[task].parameters)


def test_a_limb_has_its_ends_and_its_radius() -> None:
    cheetah = get_task("half-cheetah")
    named = [{cheetah.names[index] for index in limb} for limb in limbs_of(cheetah)]
    assert {"back_shin_x", "back_shin_z", "back_shin_radius"} in named
