"""Checks that a designer keeps the contract of `Designer`. Nothing is trained."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import product
from typing import Any

from robomore.designers import Designer
from robomore.errors import InvalidMorphology, ProposalFailed
from robomore.identity import content_key
from robomore.rewards.check import check_reward
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
)

PROPOSALS = 3
"""First morphologies and first rewards that are asked for."""

STEPS = 1_000
"""Control steps of the made-up evaluations."""


def check_designer(make: Callable[[Task, int, str], Designer], task: Task) -> None:
    """Check that a designer keeps its contract.

    Args:
        make: makes the designer for a task, a seed and an objective. It is called several times.
        task: the task to design for.

    Raises:
        AssertionError: with one sentence on what is wrong.
    """
    designer = make(task, 1, "efficiency")
    calls = _searched(designer, task)
    fresh = make(task, 1, "efficiency")
    for call in calls[::-1]:
        assert _ask(fresh, task, call.method, call.arguments) == call.answer, (
            f"`{call.method}` gives another answer when calls come in another order; draw with a "
            "seed derived from the designer's seed and the slot"
        )
    for call in calls:
        assert _ask(designer, task, call.method, call.arguments) == call.answer, (
            f"`{call.method}` gives another answer to the same arguments the second time"
        )
    _searched(make(task, 2, "fitness"), task)


@dataclass(frozen=True, slots=True)
class _Call:
    """A call of a designer, and its answer; `None` if it raised `ProposalFailed`."""

    method: str
    arguments: tuple[Any, ...]
    answer: Morphology | Reward | None


def _searched(designer: Designer, task: Task) -> list[_Call]:
    """Return the calls of a small search, whose answers are all valid."""
    for name in ("name", "provenance"):
        text = getattr(designer, name, None)
        assert isinstance(text, str) and text.strip(), f"`{name}` has to be a text"
    assert isinstance(getattr(designer, "reflects", None), bool), (
        "`reflects` has to say whether proposals depend on earlier ones, as True or False"
    )
    calls = list(_calls(designer, task))
    for method in {call.method for call in calls}:
        assert any(call.answer is not None for call in calls if call.method == method), (
            f"`{method}` raised ProposalFailed in every slot"
        )
    return calls


def _calls(designer: Designer, task: Task) -> Iterable[_Call]:
    """Yield the calls of a small search: first proposals, second attempts, and improvements."""

    def call(method: str, *arguments: Any) -> _Call:
        return _Call(method, arguments, _ask(designer, task, method, arguments))

    proposals: dict[str, list[Any]] = {"morphology": [], "reward": []}
    for kind, found in proposals.items():
        for index in range(PROPOSALS):
            earlier = tuple(found) if designer.reflects else ()
            made = call(f"propose_{kind}", Slot("first", kind, (index,)), earlier)
            yield made
            if made.answer is not None:
                found.append(made.answer)
        yield call(f"propose_{kind}", Slot("first", kind, (0,), attempt=1), ())
    designs = [Design(*pair) for pair in product(proposals["morphology"], proposals["reward"])]
    evaluations = [_evaluation(task, *numbered) for numbered in enumerate(designs)]
    best = max(evaluations, key=lambda e: (e.job.steps, e.score() or 0.0), default=None)
    if best is None:
        return
    for history in (evaluations, evaluations[::2], [best]):
        for index, kind in product(range(2), proposals):
            slot = Slot("second", kind, (len(history), index), improves=True)
            yield call(f"improve_{kind}", slot, best, tuple(history))


def _ask(
    designer: Designer, task: Task, method: str, arguments: tuple[Any, ...]
) -> Morphology | Reward | None:
    """Return the valid answer of one call, or `None` if it raised `ProposalFailed`."""
    try:
        answer: Morphology | Reward = getattr(designer, method)(*arguments)
    except ProposalFailed:
        return None
    except Exception as error:
        raise AssertionError(
            f"`{method}` raised {type(error).__name__} ({error}); a designer without a proposal "
            "has to raise ProposalFailed"
        ) from error
    wanted = Morphology if method.endswith("morphology") else Reward
    assert isinstance(answer, wanted), f"`{method}` returned no {wanted.__name__}: {answer!r}"
    assert isinstance(answer.idea, str), f"`{method}`: the idea has to be a text"
    if isinstance(answer, Morphology):
        _check_morphology(answer, task, method)
    else:
        errors = [found for found in check_reward(answer.source) if found.severity == "error"]
        assert not errors, f"`{method}` returned a reward that cannot be used: {errors[0].message}"
    return answer


def _check_morphology(morphology: Morphology, task: Task, method: str) -> None:
    try:
        accepted = task.check(morphology.parameters)
    except InvalidMorphology as error:
        raise AssertionError(f"`{method}` returned an invalid morphology: {error}") from error
    assert accepted == morphology.parameters, (
        f"`{method}` returned parameters that are no tuple of numbers in the task's order"
    )


def _evaluation(task: Task, number: int, design: Design) -> Evaluation:
    """Return a made-up evaluation: every third one failed, every fourth was stopped early."""
    steps = STEPS // 5 if number % 4 == 2 else STEPS
    job = Job(task.id, design, TrainerSettings(), steps, 1, number)
    key = content_key(design.morphology.parameters, design.reward.source, number)
    if number % 3 == 1:
        failure = Status.UNSTABLE if number % 2 else Status.REWARD_FAILED
        return Evaluation(key, job, failure, "line 2: it went wrong", steps=steps)
    volume, fitness = task.volume(design.morphology.parameters), 1.0 + number
    return Evaluation(
        key, job, Status.OK, "", fitness, volume, fitness / volume, steps=steps, seconds=1.0
    )
