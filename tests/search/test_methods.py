"""Methods by name, the two simplest ones, and plans that bound what is asked for."""

from __future__ import annotations

import itertools

import pytest

from robomore.errors import InputError
from robomore.search import METHODS, make_method
from robomore.search.random import drawn
from robomore.tasks import TASKS
from robomore.types import Evaluation, MethodSettings, Trial
from search.fakes import STEPS, CountingDesigner, Measuring, context, evaluation


class Anything(Measuring):
    """Any design is worth the sum of its parameters."""

    def __init__(self) -> None:
        super().__init__(lambda morphology, reward: morphology)
        self.fractions: list[float] = []

    def __call__(self, trials: list[Trial], *, budget_fraction: float = 1.0) -> list[Evaluation]:  # type: ignore[override]
        self.fractions += [budget_fraction] * len(trials)
        return super().__call__(trials, budget_fraction=budget_fraction)

    def evaluation_of(self, design):  # type: ignore[no-untyped-def]
        return evaluation(design, sum(design.morphology.parameters))


def test_every_method_of_ours_is_there_and_says_what_it_is() -> None:
    for name, method in METHODS.items():
        assert method.summary and method.needs_designer == (not method.provenance), name
        method(method.Settings())


def test_random_draws_valid_morphologies_under_the_reference_reward() -> None:
    measuring = Anything()
    method = make_method(MethodSettings("random", {"samples": 5}))
    best = method.run(CountingDesigner(), measuring, context())
    (batch,) = measuring.batches
    assert [t.place.index for t in batch] == [(n,) for n in range(5)]
    assert {t.design.reward for t in batch} == {context().reference.reward}
    assert len({t.design.morphology.parameters for t in batch}) == 5
    assert [e.efficiency for e in best] == sorted((e.efficiency for e in best), reverse=True)


def test_random_takes_as_many_samples_as_the_preset_has_trainings() -> None:
    measuring = Anything()
    make_method(MethodSettings("random")).run(CountingDesigner(), measuring, context())
    assert len(measuring.batches[0]) == context().evaluations


@pytest.mark.parametrize("task", TASKS)
def test_draws_stand_around_the_reference_within_the_bounds(task: str) -> None:
    chosen = TASKS[task]
    draws = [drawn(chosen, seed, 0.05).parameters for seed in range(20)]
    assert draws[0] == drawn(chosen, 0, 0.05).parameters
    for values in draws:
        chosen.check(values)
    for index, parameter in enumerate(chosen.parameters):
        size = max(abs(parameter.reference), 0.1 * (parameter.high - parameter.low))
        assert all(abs(v[index] - parameter.reference) < 0.05 * 6 * size for v in draws)


def test_reference_tries_nothing_else() -> None:
    measuring = Anything()
    (only,) = make_method(MethodSettings("reference")).run(CountingDesigner(), measuring, context())
    assert only.design == context().reference and len(measuring.batches) == 1


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("randon", {}, "Did you mean 'random'"),
        ("random", {"sampels": 3}, "no option 'sampels'. Did you mean 'samples'"),
        ("random", {"samples": 0}, "samples is 0; it takes: whole number, at least 1; or null"),
        ("random", {"samples": "x"}, 'samples is "x"; it takes: whole number'),
        ("random", {"deviation": -1.0}, "deviation is -1.0; it takes: number, above 0"),
        ("reference", {"samples": 3}, "It takes none"),
    ],
)
def test_what_cannot_be_made_is_refused(name: str, options: dict, said: str) -> None:  # type: ignore[type-arg]
    with pytest.raises(InputError, match=said):
        make_method(MethodSettings(name, options))


_SIZES = [
    (*sizes, improvement)
    for improvement, cycles in (("score", (0, 3)), ("seeds", (3,)))
    for sizes in itertools.product((1, 4, 9), (1, 3), ("in", "out"), ("none", "halving"), cycles)
]


@pytest.mark.parametrize(
    ("rows", "columns", "reference", "screening", "cycles", "improvement"), _SIZES
)
def test_a_plan_bounds_what_the_paper_s_method_asks_for(
    rows: int, columns: int, reference: str, screening: str, cycles: int, improvement: str
) -> None:
    options = {
        "morphologies": rows,
        "rewards": columns,
        "reference_reward": reference,
        "screening": screening,
        "max_cycles": cycles,
        "survivors": 0.2,
        "improvement": improvement,
        "close_call": 1.0,
    }
    method = make_method(MethodSettings("robomore", options))
    measuring, designer = Anything(), CountingDesigner()
    method.run(designer, measuring, context())
    plan = method.plan(context())
    steps: dict[tuple[object, ...], float] = {}
    for trial, fraction in zip(
        itertools.chain(*measuring.batches), measuring.fractions, strict=True
    ):
        key = trial.design.morphology.parameters, trial.design.reward.source, trial.place.repeat
        steps[key] = max(steps.get(key, 0.0), fraction)
    assert sum(steps.values()) * STEPS <= sum(stage.steps for stage in plan.stages) + 1
    assert len(measuring.batches) <= sum(stage.batches for stage in plan.stages)
    grid = next(stage for stage in plan.stages if stage.is_grid)
    for trial in itertools.chain(*measuring.batches):
        stage = plan.stage(trial.place.stage)
        assert stage in plan.stages
        if stage.shape:
            assert all(i < most for i, most in zip(trial.place.index, stage.shape, strict=True))
    asked = {
        (action, kind): sum(
            s.improves == (action == "improve") and s.kind == kind for s in designer.asked
        )
        for action in ("propose", "improve")
        for kind in ("morphology", "reward")
    }
    assert all(asked[key] <= plan.proposals[key] for key in asked)
    assert asked["propose", "morphology"] == rows and grid.shape == (rows, columns)
    if screening == "none":
        assert sum(t.place.stage == grid.name for t in measuring.batches[0]) == grid.evaluations
