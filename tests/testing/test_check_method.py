"""The contract check passes our methods and the example's, and finds each fault."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from robomore.search import SearchContext, make_method
from robomore.search.random import RandomSearch, RandomSettings
from robomore.tasks import get_task
from robomore.testing.methods import check_method
from robomore.types import Design, MethodSettings, Place, Reward, Trial

sys.path.insert(0, str(Path(__file__).parents[2] / "examples" / "hill-climb"))
from hill_climb import HillClimb, HillClimbSettings

SWIMMER = get_task("swimmer")
SMALL = {"morphologies": 3, "rewards": 2, "max_cycles": 1}


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("random", {}),
        ("reference", {}),
        ("robomore", SMALL),
        pytest.param(
            "robomore",
            {**SMALL, "improvement": "seeds", "close_call": 1.0},
            marks=pytest.mark.exhaustive,
        ),
        ("robomore", {**SMALL, "screening": "halving", "reference_reward": "out"}),
        ("robomore", {**SMALL, "slim_reference": "in", "order": "adaptive"}),
    ],
)
def test_our_methods_keep_the_contract(name: str, options: dict[str, Any]) -> None:
    check_method(lambda: make_method(MethodSettings(name, options)), SWIMMER)


def test_the_example_keeps_the_contract() -> None:
    check_method(lambda: HillClimb(HillClimbSettings()), SWIMMER)


class Worse(RandomSearch):
    """Random search with one fault."""

    def __init__(self, fault: Callable[..., Any]) -> None:
        super().__init__(RandomSettings())
        self.fault = fault

    def run(self, designer: Any, evaluate: Any, context: SearchContext) -> Any:
        return self.fault(super().run, designer, evaluate, context)


def backwards(run: Any, *given: Any) -> Any:
    return run(*given)[::-1]


def another_each_time(run: Any, designer: Any, evaluate: Any, context: SearchContext) -> Any:
    another_each_time.seed += 1  # type: ignore[attr-defined]
    return run(designer, evaluate, replace(context, seed=another_each_time.seed))  # type: ignore[attr-defined]


another_each_time.seed = 0  # type: ignore[attr-defined]


def cut_short(run: Any, designer: Any, evaluate: Any, context: SearchContext) -> Any:
    return evaluate(
        [Trial(context.reference, Place(stage="samples", index=(0,)))], budget_fraction=0.5
    )


def unplanned(run: Any, designer: Any, evaluate: Any, context: SearchContext) -> Any:
    return evaluate([Trial(context.reference, Place(stage="elsewhere"))])


def beyond(run: Any, designer: Any, evaluate: Any, context: SearchContext) -> Any:
    return evaluate([Trial(context.reference, Place(stage="samples", index=(99,)))])


def failed_too(run: Any, designer: Any, evaluate: Any, context: SearchContext) -> Any:
    trials = [
        Trial(
            Design(context.reference.morphology, Reward(f"{n}")),
            Place(stage="samples", index=(n,)),
        )
        for n in range(3)
    ]
    return sorted(evaluate(trials), key=lambda e: -(e.efficiency or 0.0))


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (backwards, "best first"),
        (another_each_time, "the same search twice"),
        (cut_short, "cut short"),
        (unplanned, "no stage of the plan"),
        (beyond, "outside of the stage's shape"),
        (failed_too, "what failed must not be returned"),
        (lambda run, *given: [], "has to return something"),
    ],
)
def test_each_fault_is_found(fault: Callable[..., Any], said: str) -> None:
    with pytest.raises(AssertionError, match=said):
        check_method(lambda: Worse(fault), SWIMMER)
