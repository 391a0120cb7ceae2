"""Hostile programs in whole evaluations: checked first, and with the check switched off."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from attempts import Attempt, attempts, parameters
from world import World, world

from robomore.evaluation import evaluate as module
from robomore.evaluation.request import Request
from robomore.rewards.check import check_reward
from robomore.sandbox.call import SandboxResult, run_sandboxed
from robomore.tasks import get_task
from robomore.tasks.fingerprint import task_key
from robomore.types import (
    Design,
    Evaluation,
    Job,
    Limits,
    Morphology,
    Reward,
    Status,
    TrainerSettings,
)
from strict import strictly

pytestmark = strictly

TASK = get_task("swimmer")
HONEST = "def _get_rew(self, x_velocity, action):\n    return x_velocity, {'speed': x_velocity}\n"
FURTHEST = 2.0
"""No policy of one constant action swims further than this in an episode, in m."""
LIMITS = Limits(
    wall_seconds=30.0,
    reward_call_seconds=0.4,
    stall_seconds=8.0,
    memory_bytes=700 * 2**20,
    file_bytes=8 * 2**20,
)


@pytest.fixture(scope="module")
def planted() -> Iterator[World]:
    with world() as made:
        yield made


@pytest.fixture(autouse=True)
def quickly(monkeypatch: pytest.MonkeyPatch, planted: World) -> list[SandboxResult]:
    """Evaluate with the quick trainer; return the result of each sandboxed call."""
    seen: list[SandboxResult] = []

    def run(
        function: str, *arguments: object, readable: object, **options: object
    ) -> SandboxResult:
        folders = [Path(__file__).parent, planted.root / "readable"]
        seen.append(
            run_sandboxed("whole:train", *arguments, readable=folders, **options)  # type: ignore[arg-type]
        )
        return seen[-1]

    monkeypatch.setattr(module, "run_sandboxed", run)
    monkeypatch.setattr(module, "compiled_trainer", lambda shape, containment: None)
    return seen


def evaluate(planted: World, name: str, source: str) -> Evaluation:
    job = Job(
        TASK.id,
        Design(Morphology(TASK.reference), Reward(source)),
        TrainerSettings("crossq", {"num_envs": 4, "net_arch": []}),
        steps=240,
        episodes=1,
        seed=1,
        limits=LIMITS,
        task_key=task_key(TASK),
    )
    request = Request(job, key=name.replace("/", "-"), scratch=str(planted.scratch(name)))
    return module.evaluate(request, lambda steps: None).evaluation


def look(
    planted: World,
    attempt: Attempt,
    evaluation: Evaluation,
    seen: list[SandboxResult],
    record: pytest.RecordProperty,
) -> None:
    """Record what came of an attempt and make sure that nothing got across."""
    result = seen[-1] if seen else SandboxResult(evaluation.status, diagnosis=evaluation.diagnosis)
    breaches = planted.breaches(result, planted.root / "scratch" / "none")
    record("attempt", attempt.words)
    record("check", "error" if evaluation.status is Status.INVALID_REWARD else "passed")
    record("outcome", evaluation.status.value)
    record("breaches", "; ".join(breaches) or "none")
    assert not breaches
    assert evaluation.ok == (evaluation.diagnosis == "")
    if evaluation.fitness is not None:
        assert abs(evaluation.fitness) < FURTHEST
        assert evaluation.volume == TASK.volume(TASK.reference)
        assert evaluation.efficiency == evaluation.fitness / evaluation.volume
        assert "fitness" not in evaluation.behaviour


@pytest.mark.parametrize("attempt", parameters())
def test_with_the_check(
    attempt: Attempt,
    planted: World,
    quickly: list[SandboxResult],
    record_property: pytest.RecordProperty,
) -> None:
    source = planted.address(attempt.source)
    faults = [it for it in check_reward(source) if it.severity == "error"]
    evaluation = evaluate(planted, attempt.name, source)
    if faults:
        assert evaluation.status is Status.INVALID_REWARD
        assert not quickly, "it was run in spite of the check"
        assert f"line {faults[0].line}: {faults[0].message}" in evaluation.diagnosis
    look(planted, attempt, evaluation, quickly, record_property)
    assert evaluation.status is not Status.FAILED, evaluation.diagnosis


@pytest.mark.exhaustive
@pytest.mark.parametrize("attempt", parameters())
def test_without_the_check(
    attempt: Attempt,
    planted: World,
    quickly: list[SandboxResult],
    record_property: pytest.RecordProperty,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "check_reward", lambda source: [])
    evaluation = evaluate(planted, attempt.name, planted.address(attempt.source))
    assert quickly, "it was not run"
    look(planted, attempt, evaluation, quickly, record_property)


def test_an_honest_evaluation_is_the_same_before_and_after(
    planted: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = evaluate(planted, "honest", HONEST)
    assert before.ok, before.diagnosis
    monkeypatch.setattr(module, "check_reward", lambda source: [])
    for name in ("cheat/patch_numpy", "escape/small_integers", "broken/global_random"):
        evaluate(planted, name, planted.address(attempts()[name].source))
    after = evaluate(planted, "honest", HONEST)
    assert (after.fitness, after.terms) == (before.fitness, before.terms)
