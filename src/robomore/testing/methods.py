"""Does a search method keep what a `SearchMethod` promises? Tried without any training."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from robomore.designers import make_designer
from robomore.errors import NothingTrained
from robomore.identity import content_key, derive_seed
from robomore.plan import Plan
from robomore.search.budget import BudgetedEvaluate, BudgetSpent
from robomore.search.method import SearchContext, SearchMethod
from robomore.settings import Budget
from robomore.tasks import Task
from robomore.types import (
    Design,
    Evaluation,
    Job,
    Morphology,
    Reward,
    Slot,
    Status,
    TrainerSettings,
    Trial,
)

STEPS = 1_000
"""Control steps of a whole candidate in the check; nothing is trained."""


def check_method(make: Callable[[], SearchMethod], task: Task, evaluations: int = 6) -> None:
    """Check that a search method keeps its contract.

    Args:
        make: makes the method; called several times.
        task: that it searches on; designs get made-up numbers, so that this takes seconds.
        evaluations: about how many trainings the search may use.

    Raises:
        AssertionError: with one sentence on what is wrong.
    """
    method = make()
    assert isinstance(method.summary, str) and method.summary, "`summary` has to be a line of text"
    assert method.needs_designer or method.provenance, (
        "a method that needs no designer has to say in `provenance` where its designs come from"
    )
    first, asked = _searched(make(), task, evaluations)
    again, _ = _searched(make(), task, evaluations)
    assert [e.key for e in first] == [e.key for e in again], (
        "the same search twice has to give the same designs; draw with `derive_seed(context.seed)`"
    )
    assert first, "a search in which everything trained has to return something"
    scores = [e.score() for e in first]
    assert all(score is not None for score in scores), "what failed must not be returned"
    assert scores == sorted(scores, key=lambda score: -(score or 0.0)), (
        "evaluations have to be returned best first"
    )
    assert all(e.job.steps == STEPS for e in first), "what was cut short must not be returned"
    _check_plan(make().plan(_context(task, evaluations)), asked)
    _check_failures(make, task, evaluations)
    _check_budget(make, task, evaluations, len(asked.trials))


class _Asked:
    """A made-up evaluator that remembers what it was asked for."""

    def __init__(self, task: Task, broken: Callable[[Trial], bool]) -> None:
        self.trials: list[Trial] = []
        self.batches = 0
        self.slots: list[Slot] = []
        self._task = task
        self._broken = broken

    def __call__(
        self, trials: Sequence[Trial], *, budget_fraction: float = 1.0
    ) -> list[Evaluation]:
        assert 0 < budget_fraction <= 1, f"budget_fraction = {budget_fraction} is not in (0, 1]"
        self.batches += 1
        return [self._measured(trial, round(budget_fraction * STEPS)) for trial in trials]

    def _measured(self, trial: Trial, steps: int) -> Evaluation:
        self.trials.append(trial)
        parameters = self._task.check(trial.design.morphology.parameters)
        content = (parameters, trial.design.reward.source, trial.place.repeat)
        job = Job(self._task.id, trial.design, TrainerSettings(), steps, 1, derive_seed(*content))
        key = content_key(*content, steps)
        if self._broken(trial):
            return Evaluation(key, job, Status.REWARD_FAILED, "it raised", steps=steps)
        volume = self._task.volume(parameters)
        fitness = 1.0 + derive_seed("fitness", content_key(*content[:2])) / 2**31
        return Evaluation(
            key, job, Status.OK, "", fitness, volume, fitness / volume, steps=steps, seconds=1.0
        )


def _context(task: Task, evaluations: int) -> SearchContext:
    reference = Design(Morphology(task.reference), Reward(task.reward))
    return SearchContext(
        task=task, reference=reference, candidate=Budget(STEPS, 1), evaluations=evaluations, seed=1
    )


class _Listening:
    """A designer that notes the slots it is asked to fill."""

    def __init__(self, designer: Any, slots: list[Slot]) -> None:
        self._designer, self._slots = designer, slots

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._designer, name)
        if not name.startswith(("propose_", "improve_")):
            return found

        def ask(slot: Slot, *given: Any) -> Any:
            self._slots.append(slot)
            return found(slot, *given)

        return ask


def _searched(
    method: SearchMethod,
    task: Task,
    evaluations: int,
    broken: Callable[[Trial], bool] = lambda trial: False,
    budget: int | None = None,
) -> tuple[list[Evaluation], _Asked]:
    asked = _Asked(task, broken)
    evaluate = BudgetedEvaluate(asked, Budget(STEPS, 1), budget)
    designer = _Listening(make_designer("offline", task, 1, "efficiency"), asked.slots)
    try:
        found = method.run(designer, evaluate, _context(task, evaluations))
    except BudgetSpent:
        found = evaluate.best("efficiency")
    return found, asked


def _check_plan(plan: Plan, asked: _Asked) -> None:
    names = [stage.name for stage in plan.stages]
    assert len(set(names)) == len(names), f"two stages of the plan have one name: {names}"
    for name in sorted({trial.place.stage for trial in asked.trials}):
        assert name in names, (
            f"an evaluation was asked for in {name!r}, which is no stage of the plan"
        )
    for stage in plan.stages:
        mine = [trial.place for trial in asked.trials if trial.place.stage == stage.name]
        for place in mine:
            assert len(place.index) == len(stage.axes), (
                f"{place} has an index of {len(place.index)} numbers for the axes {stage.axes}"
            )
            within = all(0 <= i < most for i, most in zip(place.index, stage.shape, strict=False))
            assert within, f"{place} is outside of the stage's shape {stage.shape}"
    most = sum(stage.batches for stage in plan.stages)
    assert asked.batches <= most, f"{asked.batches} batches were asked for; the plan has {most}"
    for slot in asked.slots:
        action = "improve" if slot.improves else "propose"
        count = plan.proposals.get((action, slot.kind), 0)
        used = sum(s.improves == slot.improves and s.kind == slot.kind for s in asked.slots)
        assert used <= count, f"{used} times {action} {slot.kind}; the plan has {count}"


def _check_failures(make: Callable[[], SearchMethod], task: Task, evaluations: int) -> None:
    some, _ = _searched(make(), task, evaluations, broken=_unlucky)
    assert all(e.ok for e in some), "what failed must not be returned"
    try:
        nothing, _ = _searched(make(), task, evaluations, broken=lambda trial: True)
    except NothingTrained:
        return
    assert not nothing, "where every design failed, raise NothingTrained or return nothing"


def _unlucky(trial: Trial) -> bool:
    """Return whether this design fails: about a third of all do, each always."""
    design = trial.design
    return derive_seed(design.morphology.parameters, design.reward.source) % 3 == 1


def _check_budget(
    make: Callable[[], SearchMethod], task: Task, evaluations: int, asked: int
) -> None:
    budget = STEPS * max(1, math.ceil(asked / 2))
    found, used = _searched(make(), task, evaluations, budget=budget)
    assert found, "with half of its budget a search has to return the best so far"
    full = {e.key for e in found}
    assert len(full) == len(found), "one evaluation is returned twice"
    assert len(used.trials) <= asked, "a smaller budget must not ask for more"
