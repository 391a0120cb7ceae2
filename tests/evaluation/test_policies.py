"""What a sandboxed process leaves in a policy's place is a status of its candidate at worst."""

from __future__ import annotations

import io
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from robomore.evaluation import evaluate as module
from robomore.evaluation.measure import measure
from robomore.evaluation.request import Request, Training
from robomore.identity import derive_seed
from robomore.sandbox.call import SandboxResult
from robomore.tasks import get_task
from robomore.tasks.fingerprint import task_key
from robomore.training.policy import MLPPolicy
from robomore.types import Design, Evaluation, Job, Morphology, Reward, Status, TrainerSettings

TASK = get_task("swimmer")
OBSERVATIONS, ACTIONS, HIDDEN = 8, 2, (16, 16)


def filled(
    sizes: tuple[int, ...] = (OBSERVATIONS, *HIDDEN, ACTIONS), fill: float = 0.01
) -> MLPPolicy:
    pairs = list(pairwise(sizes))
    return MLPPolicy(
        tuple(np.full(pair, fill, np.float32) for pair in pairs),
        tuple(np.full(size, fill, np.float32) for _, size in pairs),
    )


def policy(sizes: tuple[int, ...] = (OBSERVATIONS, *HIDDEN, ACTIONS), fill: float = 0.01) -> bytes:
    return filled(sizes, fill).to_bytes()


def arrays(**changed: Any) -> bytes:
    with np.load(io.BytesIO(policy())) as stored:
        content = dict(stored) | changed
    file = io.BytesIO()
    np.savez(file, **{name: array for name, array in content.items() if array is not None})
    return file.getvalue()


@pytest.fixture
def evaluated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[..., tuple[Evaluation, bytes]]:
    """Evaluate a training that says ok and leaves the given files."""

    monkeypatch.setattr("robomore.evaluation.measure._CHOICE_EPISODES", 1)

    def evaluate(*left: bytes) -> tuple[Evaluation, bytes]:
        def leaves(function: str, payload: bytes, scratch: Path, *_: object, **__: object) -> Any:
            for index, content in enumerate(left):
                (scratch / f"policy-{index:02}.npz").write_bytes(content)
            return SandboxResult(Status.OK, msgspec.json.encode(Training(100)))

        monkeypatch.setattr(module, "run_sandboxed", leaves)
        monkeypatch.setattr(module, "compiled_trainer", lambda shape, containment: None)
        job = Job(
            TASK.id,
            Design(Morphology(TASK.reference), Reward(TASK.reward)),
            TrainerSettings("crossq", {"net_arch": list(HIDDEN)}),
            steps=100,
            episodes=1,
            seed=1,
            task_key=task_key(TASK),
        )
        answer = module.evaluate(Request(job, "key", str(tmp_path / "scratch")), lambda steps: None)
        assert not (tmp_path / "scratch").exists()
        return answer.evaluation, answer.policy

    return evaluate


def test_the_best_of_several_policies_is_measured(
    evaluated: Callable[..., tuple[Evaluation, bytes]],
) -> None:
    apart = derive_seed(1, "choice")
    worth = {
        fill: measure(TASK, TASK.reference, filled(fill=fill), 1, apart).fitness
        for fill in (0.3, 0.0)
    }
    best = max(worth, key=lambda fill: worth[fill])
    assert len(set(worth.values())) == 2
    for order in ((0.3, 0.0), (0.0, 0.3)):
        found, kept = evaluated(*(policy(fill=fill) for fill in order))
        assert found.ok and kept == policy(fill=best)
        assert found.fitness is not None and found.volume == TASK.volume(TASK.reference)
        assert found.efficiency == found.fitness / found.volume


@pytest.mark.parametrize(
    ("left", "said"),
    [
        ((), "no policy"),
        ((b"no archive",), "no file of arrays"),
        ((policy((OBSERVATIONS + 1, *HIDDEN, ACTIONS)),), "where this robot has"),
        ((policy((OBSERVATIONS, *HIDDEN, ACTIONS + 1)),), "where this robot has"),
        ((policy((OBSERVATIONS, 17, 16, ACTIONS)),), "other layers"),
        ((policy((OBSERVATIONS, 16, ACTIONS)),), "other layers"),
        ((policy((OBSERVATIONS, 3000, 3000, ACTIONS)),), "other layers"),
        ((arrays(weight0=np.zeros((OBSERVATIONS, 16))),), "<f8"),
        ((arrays(weight0=np.zeros((OBSERVATIONS, 16), "U9")),), "<U9"),
        ((arrays(more=np.zeros(1, np.float32)),), "is not a policy"),
        ((arrays(weight3=np.zeros((2, 2), np.float32)),), "is not a policy"),
        ((arrays(bias2=None),), "is not a policy"),
        ((arrays(bias2=np.full(ACTIONS, np.nan, np.float32)),), "not finite"),
        ((policy(), b"no archive"), "no file of arrays"),
    ],
)
def test_any_other_form_is_a_status_of_the_candidate(
    evaluated: Callable[..., tuple[Evaluation, bytes]], left: tuple[bytes, ...], said: str
) -> None:
    found, kept = evaluated(*left)
    assert found.status is Status.CRASHED and said in found.diagnosis and not kept


def test_finite_weights_whose_actions_are_not_numbers_are_a_status_too(
    evaluated: Callable[..., tuple[Evaluation, bytes]],
) -> None:
    opposed = np.ones((16, ACTIONS), np.float32)
    opposed[::2] = -1
    found, kept = evaluated(
        arrays(
            bias0=np.full(16, 3e38, np.float32),
            weight1=np.full((16, 16), 3e38, np.float32),
            weight2=opposed,
        )
    )
    assert found.status is Status.TRAINING_DIVERGED and not kept
    assert "not finite numbers" in found.diagnosis
