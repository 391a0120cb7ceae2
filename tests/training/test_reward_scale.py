"""Normalised rewards: units, offsets and extremes, on numbers and on trainings."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from probes import SETTINGS, Cart

from robomore.training.crossq import CrossQ
from robomore.training.loop import TrainingRun
from robomore.training.reward_scale import CLIP, LARGEST, SPREAD, measure_scale
from robomore.training.trainer import Transition

GAMMA = 0.9
SHAPE = 400, 3


def never() -> NDArray[np.bool_]:
    return np.zeros(SHAPE, np.bool_)


def every(steps: int) -> NDArray[np.bool_]:
    ended = never()
    ended[steps - 1 :: steps] = True
    return ended


def rewards(seed: int = 0) -> NDArray[np.float64]:
    return np.random.default_rng(seed).normal(1.0, 2.0, SHAPE)


def test_values_are_those_of_a_plain_loop() -> None:
    reward, ended = rewards(), every(7)
    terminated = ended & (np.arange(SHAPE[1]) == 1)
    scale = measure_scale(reward, ended, terminated, GAMMA)
    values = []
    for env in range(SHAPE[1]):
        for start in range(SHAPE[0]):
            total, factor, alive = 0.0, 1.0, True
            for step in range(start, SHAPE[0]):
                total += factor * reward[step, env]
                factor *= GAMMA
                if ended[step, env]:
                    alive = not terminated[step, env]
                    break
            values.append(total + factor * alive * scale.usual)
    assert scale.usual == pytest.approx(np.mean(values))
    assert scale.unit * SPREAD == pytest.approx(np.std(values))


@pytest.mark.parametrize("power", [-40, -1, 3, 200])
def test_a_power_of_two_changes_no_bit(power: int) -> None:
    reward = rewards()
    terminated = every(9)
    plain = measure_scale(reward, terminated, terminated, GAMMA)
    scaled = measure_scale(reward * 2.0**power, terminated, terminated, GAMMA)
    assert (scaled.to_array() == plain.to_array() * 2.0**power).all()
    assert (scaled.normalize(reward * 2.0**power, GAMMA) == plain.normalize(reward, GAMMA)).all()
    assert scaled.value_of_termination == plain.value_of_termination


def test_an_offset_is_taken_away_where_episodes_do_not_terminate() -> None:
    reward, ended = rewards(), every(50)
    plain = measure_scale(reward, ended, never(), GAMMA)
    offset = measure_scale(reward + 1000, ended, never(), GAMMA)
    assert offset.normalize(reward + 1000, GAMMA) == pytest.approx(
        plain.normalize(reward, GAMMA), abs=1e-9
    )


def test_values_of_terminating_episodes_are_the_same_on_the_new_scale() -> None:
    reward = rewards()[:20, 0]
    scale = measure_scale(rewards(), every(20), every(20), GAMMA)
    value = sum(GAMMA**k * r for k, r in enumerate(reward))
    normalised = sum(GAMMA**k * r for k, r in enumerate(scale.normalize(reward, GAMMA)))
    normalised += GAMMA**20 * scale.value_of_termination
    assert normalised * scale.unit + scale.usual == pytest.approx(value)


def test_rare_spikes_are_clipped_and_leave_the_others_their_size() -> None:
    reward = rewards()
    plain = measure_scale(reward, every(50), never(), GAMMA)
    reward[7, 1] = 1e80
    reward[90, 0] = -1e60
    spiked = measure_scale(reward, every(50), never(), GAMMA)
    assert spiked.normalize(reward, GAMMA).max() < 3 * CLIP * SPREAD
    assert 0.5 < spiked.unit / plain.unit < 4


def test_rewards_that_are_nearly_always_zero_keep_the_rest() -> None:
    reward = np.zeros(SHAPE)
    reward[100, 0] = 1.0
    scale = measure_scale(reward, every(50), never(), GAMMA)
    assert scale.normalize(reward, GAMMA).max() > 1


@pytest.mark.parametrize("value", [0.0, 1.0, -3e-300, LARGEST])
def test_a_reward_that_never_changes_becomes_zero(value: float) -> None:
    scale = measure_scale(np.full(SHAPE, value), every(50), never(), GAMMA)
    assert np.abs(scale.normalize(np.full(SHAPE, value), GAMMA)).max() < 1e-6
    assert np.isfinite(scale.to_array()).all()


class Changed(Cart):
    """The cart with another reward."""

    def __init__(self, change: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> None:
        self.change = change

    def step(self, actions: NDArray[np.floating[Any]]) -> Transition:
        transition = super().step(actions)
        return replace(transition, reward=self.change(transition.reward))


def policy(change: Callable[[NDArray[np.float64]], NDArray[np.float64]], steps: int) -> TrainingRun:
    run = TrainingRun(CrossQ(SETTINGS), SETTINGS, Changed(change), seed=1)
    while run.steps < steps:
        run.advance()
    return run


def actions(run: TrainingRun) -> NDArray[np.float32]:
    return run.policies()[-1].act(np.random.default_rng(0).uniform(-1, 1, (200, 2)))


def test_a_power_of_two_times_the_reward_gives_the_same_policy_to_the_last_bit() -> None:
    plain = policy(lambda reward: reward, 1_000)
    for factor in (2.0**-10, 2.0**10):
        scaled = policy(lambda reward, f=factor: f * reward, 1_000)  # type: ignore[misc]
        assert (actions(scaled) == actions(plain)).all()


def test_any_factor_gives_the_same_policy_to_rounding() -> None:
    plain = policy(lambda reward: reward, 300)
    scaled = policy(lambda reward: 1000 * reward, 300)
    assert actions(scaled) == pytest.approx(actions(plain), abs=1e-3)


def test_an_offset_gives_the_same_greedy_policy() -> None:
    plain = policy(lambda reward: reward, 4_000)
    offset = policy(lambda reward: reward + 5, 4_000)
    assert np.abs(actions(offset) - actions(plain)).mean() < 0.1


def test_rewards_over_ninety_powers_of_ten_train() -> None:
    def extreme(reward: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.exp(np.minimum(-100 * reward, 250)) * 1e-12

    run = policy(extreme, 1_000)
    assert all(math.isfinite(value) for value in run.buffer.scale.to_array().tolist())
    assert np.isfinite(actions(run)).all()
