"""The same seed gives the same bits, in one go or continued from a checkpoint."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from probes import SAC_SETTINGS, SB3_SETTINGS, SETTINGS

from robomore.envs.vector_env import VectorEnv
from robomore.rewards.load import load_reward
from robomore.tasks import get_task
from robomore.testing.probe_env import ProbeEnv
from robomore.testing.trainers import check_trainer
from robomore.testing.trainers import same_result as same
from robomore.training import checkpoint as module
from robomore.training.checkpoint import (
    Checkpoint,
    drop_older,
    load_checkpoint,
    save_checkpoint,
)
from robomore.training.crossq import CrossQ
from robomore.training.sac import SAC
from robomore.training.settings import make_trainer
from robomore.training.trainer import Progress, Trainer, TrainingResult

FULL = SETTINGS.buffer_size + 160
HELD = replace(SETTINGS, max_noise_repeat=5)


@dataclass(frozen=True)
class Training:
    """A trainer on a probe."""

    trainer: Trainer
    policies: int

    def __call__(
        self,
        steps: int,
        seed: int = 3,
        checkpoint: Path | None = None,
        progress: Progress | None = None,
    ) -> TrainingResult:
        return self.trainer.train(ProbeEnv(), steps, seed, checkpoint, progress)


@pytest.fixture(params=["crossq", "sac", "sb3"])
def train(request: pytest.FixtureRequest) -> Training:
    if request.param == "crossq":
        return Training(CrossQ(HELD), SETTINGS.num_eval_checkpoints)
    if request.param == "sac":
        return Training(SAC(SAC_SETTINGS), SAC_SETTINGS.num_eval_checkpoints)
    pytest.importorskip("stable_baselines3")
    return Training(make_trainer(SB3_SETTINGS), 1)


def test_the_contract_is_kept(train: Training) -> None:
    check_trainer(lambda: train.trainer, steps=640)
    assert len(train(512).policies) == train.policies


@pytest.mark.parametrize("first", [64, 320, FULL - 32])
def test_a_continued_training_is_an_uninterrupted_one(
    train: Training, tmp_path: Path, first: int
) -> None:
    train(first, checkpoint=tmp_path / "a")
    continued = train(FULL, checkpoint=tmp_path / "a")
    assert same(continued, train(FULL, checkpoint=tmp_path / "b"))
    one, other = load_checkpoint(tmp_path / "a"), load_checkpoint(tmp_path / "b")
    assert one is not None and other is not None
    assert one.facts == other.facts
    for part in ("arrays", "environment"):
        left, right = getattr(one, part), getattr(other, part)
        assert left.keys() == right.keys()
        assert all(np.array_equal(left[name], right[name]) for name in left)


KEEPING = """
from collections import deque
HISTORY = []
class Ema:
    value = 0.0
    def update(self, v):
        self.value += 0.1 * (v - self.value)
        return self.value
def make():
    queue, n = deque(maxlen=4), 0
    def smooth(v):
        nonlocal n
        n += 1
        queue.append(v)
        return sum(queue) / n
    return smooth
smooth, ema = make(), Ema()
def _get_rew(self, x_velocity, action, memory={"last": 0.0}):
    v = float(x_velocity)
    HISTORY.append(v)
    jerk, memory["last"] = v - memory["last"], v
    _get_rew.most = max(getattr(_get_rew, "most", 0.0), v)
    self.own = getattr(self, "own", Ema())
    kept = smooth(v) + ema.update(v) + self.own.update(v) + _get_rew.most
    late = 1e-3 * self.training_steps
    return v + kept - jerk + sum(HISTORY[-5:]) / len(HISTORY) + late, {"kept": kept}
"""
"""A reward that keeps something in every place that comes to mind."""


@pytest.mark.exhaustive
def test_a_continued_training_has_the_same_policy_whatever_the_reward_keeps(
    tmp_path: Path,
) -> None:
    task, trainer = get_task("swimmer"), CrossQ(SETTINGS)

    def train(steps: int, checkpoint: Path | None = None) -> TrainingResult:
        reward = load_reward(KEEPING)
        env = VectorEnv(task, task.reference, SETTINGS.num_envs, reward, episode_seconds=1.0)
        return trainer.train(env, steps, 3, checkpoint)

    whole = train(320)
    train(192, tmp_path)
    assert same(train(320, tmp_path), whole)


def test_a_finished_training_is_not_done_again(train: Training, tmp_path: Path) -> None:
    done = train(512, checkpoint=tmp_path)
    told: list[int] = []
    assert same(done, train(512, checkpoint=tmp_path, progress=told.append))
    assert told == [512]


def test_a_checkpoint_past_the_budget_or_of_another_training_is_not_used(
    train: Training, tmp_path: Path
) -> None:
    train(512, checkpoint=tmp_path)
    assert same(train(256, checkpoint=tmp_path), train(256))
    assert same(train(512, seed=4, checkpoint=tmp_path), train(512, seed=4))


@pytest.mark.parametrize(
    "damage",
    [
        lambda folder: (folder / "checkpoint-0.json").write_text("{"),
        lambda folder: (folder / "checkpoint-0.json").rename(folder / "checkpoint-1.json"),
        lambda folder: [path.write_bytes(b"PK") for path in folder.glob("*.npz")],
        lambda folder: [path.unlink() for path in folder.glob("environment*.npz")],
    ],
)
def test_a_damaged_checkpoint_is_not_used(tmp_path: Path, damage: Callable[[Path], Any]) -> None:
    save_checkpoint(tmp_path, Checkpoint({"a": 1}, {"b": np.ones(2)}, {"c": np.zeros(1)}))
    damage(tmp_path)
    assert load_checkpoint(tmp_path) is None


@pytest.mark.parametrize("place", range(50))
def test_a_checkpoint_damaged_anywhere_is_whole_or_not_used(tmp_path: Path, place: int) -> None:
    numbers = np.random.default_rng(place).random((4, 30))
    stored = Checkpoint({"a": [1.25, "b"], "rounds": 128}, {"b": numbers}, {"c": numbers[0]})
    save_checkpoint(tmp_path, stored)
    damage(tmp_path, random.Random(place))
    found = load_checkpoint(tmp_path)
    if found is not None:
        assert found.facts == stored.facts
        assert found.arrays["b"].tobytes() == numbers.tobytes()
        assert found.environment["c"].tobytes() == numbers[0].tobytes()


@pytest.mark.parametrize("place", range(3))
def test_a_training_with_a_damaged_checkpoint_ends_as_one_without(
    tmp_path: Path, place: int, caplog: pytest.LogCaptureFixture
) -> None:
    train = Training(CrossQ(SETTINGS), SETTINGS.num_eval_checkpoints)
    train(320, checkpoint=tmp_path)
    damage(tmp_path, random.Random(100 + place))
    assert same(train(512, checkpoint=tmp_path), train(512))
    assert "starting anew" in caplog.text


def damage(folder: Path, choose: random.Random) -> None:
    """Flip some bits of one byte in one of the files, or cut it off there."""
    path = choose.choice(sorted(folder.iterdir()))
    content = bytearray(path.read_bytes())
    at = choose.randrange(len(content))
    content[at] ^= choose.randrange(1, 256)
    path.write_bytes(content[:at] if choose.random() < 0.3 else content)


def test_a_writer_that_dies_leaves_the_old_checkpoint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def dies(path: Path, text: str, encoding: str) -> None:
        path.write_bytes(text.encode()[:-1])
        raise KeyboardInterrupt

    for number in (1, 2):
        save_checkpoint(tmp_path, Checkpoint({"a": number}, {"b": np.full(2, number)}, {}))
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_text", dies)
        with pytest.raises(KeyboardInterrupt):
            save_checkpoint(tmp_path, Checkpoint({"a": 3}, {"b": np.full(2, 3)}, {}))
    found = load_checkpoint(tmp_path)
    assert found is not None
    assert found.facts == {"a": 2}
    assert found.arrays["b"].tolist() == [2, 2]


def test_objects_are_never_loaded(tmp_path: Path) -> None:
    arrays = {"b": np.array([{"an": "object"}], dtype=object)}
    with pytest.raises(ValueError, match="pickle"):
        save_checkpoint(tmp_path, Checkpoint({}, arrays, {}))


def test_nothing_is_removed_or_renamed_where_it_is_forbidden(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As in a sandboxed process, where somebody else drops what is old."""

    def forbidden(*args: Any, **options: Any) -> None:
        raise PermissionError

    with monkeypatch.context() as patch:
        for name in ("unlink", "rename", "replace", "rmdir", "remove"):
            patch.setattr(module.PlainFolder, "remove", forbidden)
            patch.setattr(f"os.{name}", forbidden)
        for number in (1, 2):
            save_checkpoint(tmp_path, Checkpoint({"a": number}, {"b": np.full(2, number)}, {}))
    (tmp_path / "left").mkdir()
    assert len(list(tmp_path.iterdir())) == 7
    drop_older(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "arrays-1.npz",
        "checkpoint-1.json",
        "environment-1.npz",
    ]
    found = load_checkpoint(tmp_path)
    assert found is not None and found.facts == {"a": 2}
