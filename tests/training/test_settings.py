"""Settings by name: what is taken and what is refused."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from robomore.errors import InputError
from robomore.training import settings
from robomore.training.policy import MLPPolicy, file_bytes
from robomore.training.settings import (
    CrossQSettings,
    SACSettings,
    SB3Settings,
    ensure_trainer,
    hidden_layers,
    least_steps,
    settings_from,
)
from robomore.types import TrainerSettings


def test_options_override_fields() -> None:
    options = {"net_arch": [64, 64], "actor_lr": 1, "target_entropy": -2.5}
    found = settings_from(TrainerSettings("crossq", options))
    assert found == CrossQSettings(net_arch=(64, 64), actor_lr=1.0, target_entropy=-2.5)
    assert isinstance(found.actor_lr, float)
    assert hash(found) == hash(settings_from(TrainerSettings("crossq", options)))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"batch": 3}, "'batch'.*batch_size"),
        ({"batch_size": 0}, "batch_size"),
        ({"batch_size": 2.5}, "batch_size"),
        ({"net_arch": "256"}, "net_arch"),
        ({"net_arch": [256, -1]}, "net_arch"),
        ({"gamma": 1.0}, "gamma"),
        ({"critic_lr": float("nan")}, "critic_lr"),
        ({"critic_lr": float("inf")}, "critic_lr"),
        ({"critic_lr": "fast"}, "critic_lr"),
        ({"policy_delay": True}, "policy_delay"),
        ({"num_bins": 1}, "num_bins = 1.*at least 2"),
        ({"num_bins": 51, "normalize_rewards": False}, "normalize_rewards=true"),
        ({"min_q_weight": 0.5}, "n_critics=2"),
    ],
)
def test_what_makes_no_sense_is_refused(options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        settings_from(TrainerSettings("crossq", options))


def test_an_unknown_trainer_is_refused_with_the_known_ones() -> None:
    with pytest.raises(InputError, match=r"'sarsa'.*crossq"):
        settings_from(TrainerSettings("sarsa"))


@pytest.mark.parametrize(
    ("name", "options", "least"),
    [
        ("crossq", {}, 5_120),
        ("sac", {}, 10_112),
        ("sac", {"learning_starts": 10_112}, 10_112),
        ("sb3", {"learning_starts": 10_112}, 10_240),  # it learns beyond that number only
        ("crossq", {"train_freq": 1_000}, 16_000),
        ("crossq", {"learning_starts": 1, "train_freq": 1, "num_envs": 3}, 3),
    ],
)
def test_a_training_that_would_learn_nothing_is_refused(
    name: str, options: dict[str, Any], least: int
) -> None:
    trainer = TrainerSettings(name, options)
    for steps in (1, least - 1):
        with pytest.raises(InputError, match=rf"learns nothing in {steps} .* at least {least} "):
            ensure_trainer(trainer, steps)
    assert least_steps(trainer) == least


@pytest.mark.parametrize(
    ("steps", "remedy"),
    [(127, "a smaller --trainer-option train_freq="), (128, "learning_starts=")],
)
def test_the_remedy_is_that_of_what_is_in_the_way(steps: int, remedy: str) -> None:
    with pytest.raises(InputError, match=remedy):
        ensure_trainer(TrainerSettings("crossq"), steps)


def test_the_steps_of_a_trainer_of_one_s_own_are_those_it_names(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    @dataclass(frozen=True)
    class Own:
        num_envs: int = 4
        episode_seconds: float | None = None
        replace_rk4: bool = False
        learning_starts: int = 10

    own = settings.Algorithm(Own, "robomore.training.crossq:CrossQ")
    monkeypatch.setitem(settings.TRAINERS._items, "own", own)
    with pytest.raises(InputError, match="first 10 are random actions; give it at least 11 "):
        ensure_trainer(TrainerSettings("own"), 10)
    ensure_trainer(TrainerSettings("own"), 11)
    ensure_trainer(TrainerSettings("own"))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"buffer_size": 10}, "buffer_size = 10 .*num_envs = 16.*at least 16"),
        ({"buffer_size": 7, "num_envs": 8}, "at least 8"),
        ({"num_eval_checkpoints": 17}, "num_eval_checkpoints.*16"),
        ({"num_eval_checkpoints": 0}, "num_eval_checkpoints.*1"),
        ({"n_steps": 1_001}, "n_steps is 1001; it takes: whole number, .*at most 1000"),
        ({"net_arch": [16] * 16}, "16 hidden layers; give 15 at most"),
        ({"net_arch": [4096, 4096]}, r"net_arch = \[4096, 4096\] .*81 MiB, and 64 MiB can be kept"),
    ],
)
@pytest.mark.parametrize("name", ["crossq", "sac"])
def test_what_cannot_work_is_refused_with_the_range(
    name: str, options: dict[str, int], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        settings_from(TrainerSettings(name, options))


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("crossq", {"batch_size": 1}, "batch_size is 1; it takes: whole number, at least 2"),
        ("crossq", {"renorm_warmup_steps": -5}, "renorm_warmup_steps is -5; .*at least 0"),
        ("sb3", {"buffer_size": 10}, "buffer_size = 10 .*at least 16"),
        ("sb3", {"net_arch": [16] * 16}, "give 15 at most"),
    ],
)
def test_what_one_trainer_alone_cannot_take_is_refused(
    name: str, options: dict[str, Any], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        settings_from(TrainerSettings(name, options))


@pytest.mark.parametrize("net_arch", [(), (16,) * 15, (3_000, 3_000)])
def test_every_network_that_is_taken_gives_a_policy_that_can_be_read(
    net_arch: tuple[int, ...],
) -> None:
    assert CrossQSettings(net_arch=net_arch).net_arch == net_arch
    sizes = (900, *net_arch, 90)
    policy = MLPPolicy(
        tuple(np.zeros(pair, np.float32) for pair in pairwise(sizes)),
        tuple(np.zeros(size, np.float32) for size in sizes[1:]),
    )
    content = policy.to_bytes()
    assert MLPPolicy.from_bytes(content).sizes == sizes
    assert len(content) <= file_bytes(sizes)


def test_layers_are_known_of_our_own_trainers_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    own = settings.Algorithm(CrossQSettings, "elsewhere:Trainer")
    monkeypatch.setitem(settings.TRAINERS._items, "own", own)
    assert hidden_layers(TrainerSettings("own")) is None
    assert hidden_layers(TrainerSettings("sb3", {"net_arch": [7]})) == (7,)


def test_the_least_buffer_and_the_most_checkpoints_are_taken() -> None:
    options = {"buffer_size": 16, "num_eval_checkpoints": 16}
    assert settings_from(TrainerSettings("crossq", options)).buffer_size == 16


def test_a_missing_package_is_named_with_the_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    needing = settings.Algorithm(
        CrossQSettings, "robomore.training.crossq:CrossQ", ("json", "no_such_package"), "buy one"
    )
    monkeypatch.setitem(settings.TRAINERS._items, "needing", needing)
    with pytest.raises(InputError, match=r"needs no_such_package, .* buy one"):
        ensure_trainer(TrainerSettings("needing"))
    with pytest.raises(InputError, match="buy one"):
        settings.make_trainer(TrainerSettings("needing"))


def test_both_ways_to_the_paper_have_the_same_settings() -> None:
    ours, theirs = asdict(SACSettings()), asdict(SB3Settings())
    assert theirs == {name: ours[name] for name in theirs}


def test_a_third_party_can_add_a_trainer(monkeypatch: pytest.MonkeyPatch) -> None:
    class Point:
        name, value, dist = "other", "other_package:OTHER", None

        def load(self) -> settings.Algorithm:
            return settings.Algorithm(CrossQSettings, "robomore.training.crossq:CrossQ")

    # The registry keeps here what it found installed.
    monkeypatch.setitem(vars(settings.TRAINERS), "_plugins", {"other": Point()})
    assert settings_from(TrainerSettings("other")) == CrossQSettings()
    with pytest.raises(InputError, match="crossq, sac, sb3, other"):
        settings_from(TrainerSettings("sarsa"))


def test_a_trainer_without_settings_of_its_simulation_is_refused() -> None:
    @dataclass(frozen=True)
    class Own:
        num_envs: int = 1

    with pytest.raises(InputError, match="'own' lacks episode_seconds, replace_rk4 among"):
        settings.TRAINERS.register("own", settings.Algorithm(Own, "own:Own"))


def test_settings_need_no_jax() -> None:
    code = "import sys, robomore.training.settings; assert 'jax' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
