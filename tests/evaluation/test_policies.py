"""What a sandboxed process leaves in a policy's place is a status of its candidate at worst."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from robomore.errors import FitnessFailed
from robomore.evaluation import evaluate as module
from robomore.evaluation.measure import measure
from robomore.evaluation.request import Request, Training
from robomore.identity import derive_seed
from robomore.sandbox.call import SandboxResult
from robomore.tasks import get_task
from robomore.tasks.fingerprint import task_key
from robomore.training.checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from robomore.training.policy import MLPPolicy
from robomore.training.settings import TRAINERS, Algorithm
from robomore.types import (
    Curve,
    Design,
    Evaluation,
    Job,
    Morphology,
    Reward,
    Status,
    TermStatistics,
    TrainerSettings,
)

TASK = get_task("swimmer")
OBSERVATIONS, ACTIONS, HIDDEN = 8, 2, (16, 16)
CROSSQ = TrainerSettings("crossq", {"net_arch": list(HIDDEN)})
TRAINED = Training(
    100,
    {"speed": TermStatistics(0.5, -1.0, 2.0)},
    ("the physics diverged in 1 episode",),
    Curve((100,), {"episode_return": (1.5,)}),
)


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

    def evaluate(
        *left: bytes,
        status: Status = Status.OK,
        checkpoint: str = "",
        trainer: TrainerSettings = CROSSQ,
    ) -> tuple[Evaluation, bytes]:
        def leaves(function: str, payload: bytes, scratch: Path, *_: object, **__: object) -> Any:
            for index, content in enumerate(left):
                (scratch / f"policy-{index:02}.npz").write_bytes(content)
            return SandboxResult(status, msgspec.json.encode(TRAINED), seconds=70.0)

        monkeypatch.setattr(module, "run_sandboxed", leaves)
        monkeypatch.setattr(module, "compiled_trainer", lambda shape, containment: None)
        job = Job(
            TASK.id,
            Design(Morphology(TASK.reference), Reward(TASK.reward)),
            trainer,
            steps=100,
            episodes=1,
            seed=1,
            task_key=task_key(TASK),
        )
        request = Request(job, "key", str(tmp_path / "scratch"), checkpoint)
        answer = module.evaluate(request, lambda steps: None)
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


@pytest.mark.parametrize("own", [{"pi": [8], "qf": [16]}, 8])
def test_what_a_trainer_of_one_s_own_calls_net_arch_is_its_own_affair(
    evaluated: Callable[..., tuple[Evaluation, bytes]], monkeypatch: pytest.MonkeyPatch, own: Any
) -> None:
    @dataclass(frozen=True)
    class Own:
        num_envs: int = 4
        episode_seconds: float | None = None
        replace_rk4: bool = False
        net_arch: Any = None

    monkeypatch.setitem(TRAINERS._items, "own", Algorithm(Own, "own:Own"))
    left = policy((OBSERVATIONS, 8, ACTIONS))
    found, kept = evaluated(left, trainer=TrainerSettings("own", {"net_arch": own}))
    assert found.ok and kept == left


def unmeasurable() -> bytes:
    """Return a policy with finite weights whose actions are no numbers."""
    opposed = np.ones((16, ACTIONS), np.float32)
    opposed[::2] = -1
    return arrays(
        bias0=np.full(16, 3e38, np.float32),
        weight1=np.full((16, 16), 3e38, np.float32),
        weight2=opposed,
    )


@pytest.mark.parametrize("left", [(unmeasurable(),), (unmeasurable(), unmeasurable())])
def test_finite_weights_whose_actions_are_not_numbers_are_a_status_too(
    evaluated: Callable[..., tuple[Evaluation, bytes]], left: tuple[bytes, ...]
) -> None:
    found, kept = evaluated(*left)
    assert found.status is Status.TRAINING_DIVERGED and not kept
    assert "not finite numbers" in found.diagnosis


@pytest.mark.parametrize("place", range(3))
def test_a_late_policy_that_cannot_be_measured_is_left_out(
    evaluated: Callable[..., tuple[Evaluation, bytes]], place: int
) -> None:
    left = [policy(fill=0.3), policy(fill=0.0)]
    _, best = evaluated(*left)
    left.insert(place, unmeasurable())
    found, kept = evaluated(*left)
    assert found.ok and kept == best


def fails(*_: object) -> None:
    raise FitnessFailed("no number")


def breaks(*_: object) -> None:
    raise RuntimeError("a fault of ours")


@pytest.mark.parametrize(
    ("where", "what", "status", "said"),
    [
        ("measure", fails, Status.FAILED, "no number"),
        ("choose", fails, Status.FAILED, "no number"),
        ("measure", breaks, Status.FAILED, "Traceback"),
        ("choose", breaks, Status.FAILED, "Traceback"),
    ],
)
def test_what_fails_after_training_keeps_what_training_cost_and_how_it_went(
    evaluated: Callable[..., tuple[Evaluation, bytes]],
    monkeypatch: pytest.MonkeyPatch,
    where: str,
    what: Callable[..., Any],
    status: Status,
    said: str,
) -> None:
    monkeypatch.setattr(module, where, what)
    found, _ = evaluated(policy())
    assert found.status is status and said in found.diagnosis
    assert 70.0 < found.seconds < 90.0 and found.steps == 100 and found.body
    assert (found.terms, found.notes, found.curve) == (TRAINED.terms, TRAINED.notes, TRAINED.curve)


def test_a_policy_that_cannot_be_used_keeps_them_too(
    evaluated: Callable[..., tuple[Evaluation, bytes]],
) -> None:
    found, _ = evaluated(b"no archive")
    assert (found.status, found.curve, found.steps) == (Status.CRASHED, TRAINED.curve, 100)


def test_an_older_checkpoint_stays_where_the_writer_of_the_latest_died(
    evaluated: Callable[..., tuple[Evaluation, bytes]], tmp_path: Path
) -> None:
    folder = tmp_path / "checkpoint"
    save_checkpoint(folder, Checkpoint({"a": 1}, {"b": np.ones(2)}, {}))
    (folder / "checkpoint-1.json").write_text('{"version": 4, "num')
    evaluated(status=Status.CRASHED, checkpoint=str(folder))
    found = load_checkpoint(folder)
    assert found is not None and found.facts == {"a": 1}
    save_checkpoint(folder, Checkpoint({"a": 2}, {"b": np.ones(2)}, {}))
    (folder / "left-there").touch()
    evaluated(policy(), checkpoint=str(folder))
    assert len(list(folder.iterdir())) == 3
