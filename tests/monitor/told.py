"""Events of a small run, and a clock that is ours."""

from __future__ import annotations

from pathlib import Path

import pytest

from robomore.events import (
    BatchBegan,
    Finished,
    Progressed,
    Proposed,
    RunBegan,
    Started,
)
from robomore.monitor import RunState
from robomore.plan import Plan, Stage
from robomore.settings import Budget, FinalSettings, RunSettings
from robomore.types import (
    Design,
    Evaluation,
    Job,
    MethodSettings,
    Morphology,
    Place,
    Reward,
    Slot,
    Status,
    TrainerSettings,
)

SETTINGS = RunSettings(
    method=MethodSettings("ours"),
    trainer=TrainerSettings(),
    candidate=Budget(1_000, 1),
    final=FinalSettings(2_000, 1, finalists=1, seeds=1),
    evaluations=4,
)
PLAN = Plan(
    (
        Stage(name="looks", axes=("morphology",), role="screening"),
        Stage(
            name="matrix",
            axes=("morphology", "reward"),
            shape=(2, 2),
            evaluations=4,
            steps=4_000,
        ),
        Stage(
            name="evolution",
            axes=("branch", "cycle"),
            shape=(1, 1),
            evaluations=2,
            steps=2_000,
            batches=2,
        ),
        Stage(
            name="last", axes=("finalist",), shape=(1,), evaluations=4, steps=8_000, role="final"
        ),
    )
)
"""Its stages are called as no method of ours calls them."""

BEGAN = RunBegan(
    fitness_unit="m",
    task="ant",
    preset="quick",
    settings=SETTINGS,
    plan=PLAN,
    designer="offline",
    provenance="No LLM was used.",
    seed=3,
    workers=2,
    folder=Path("runs/x"),
    containment="strict (files)",
)
GRID = tuple(Place(stage="matrix", index=(i, j)) for i in range(2) for j in range(2))
LATER = Place(stage="evolution", index=(0, 0), changed="reward")
LAST = tuple(
    Place(stage="last", index=(0,), changed=role, repeat=1) for role in ("found", "reference")
)


class Clock:
    """Stands still until it is set."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def measured(key: str, fitness: float, steps: int = 1_000) -> Evaluation:
    design = Design(Morphology((1.0,)), Reward(key))
    job = Job("ant", design, TrainerSettings(), steps, 1, 0)
    return Evaluation(
        key, job, Status.OK, fitness=fitness, volume=0.5, efficiency=2 * fitness, steps=steps
    )


def failed(key: str) -> Evaluation:
    good = measured(key, 1.0)
    return Evaluation(key, good.job, Status.REWARD_FAILED, "line 3: [bold]NameError\nmore")


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def state(clock: Clock) -> RunState:
    """After 10 s: one of four is measured, one is half done, one failed, one waits."""
    state = RunState(clock)
    state(BEGAN)
    state(Proposed(Slot("matrix", "morphology", (0,)), "long [legs]"))
    state(BatchBegan(GRID, known=0))
    state(Started("a", GRID[0], 1_000))
    state(Started("b", GRID[1], 1_000))
    clock.now += 10
    state(Progressed("b", 500))
    state(Finished(measured("a", 3.0), GRID[0], known=False))
    state(Started("c", GRID[2], 1_000))
    state(Finished(failed("c"), GRID[2], known=False))
    return state
