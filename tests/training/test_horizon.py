"""How far a training looks ahead, as it goes on."""

from __future__ import annotations

from dataclasses import replace

import pytest
from probes import SETTINGS

from robomore.testing.probe_env import ProbeEnv
from robomore.training.crossq import CrossQ
from robomore.training.loop import CHECKPOINT_GROWTH, LONGEST_HORIZON, TrainingRun


def gammas(gamma: float, start: int | None, steps: list[int]) -> list[float]:
    settings = replace(SETTINGS, gamma=gamma, horizon_growth_start=start)
    run = TrainingRun(CrossQ(SETTINGS), settings, ProbeEnv(), seed=1)
    found = []
    for run.steps in steps:
        found.append(run.gamma)
    return found


def test_the_horizon_stays_unless_it_is_asked_to_grow() -> None:
    assert gammas(0.98, None, [0, 64, 10_000, 10**7]) == [0.98] * 4


def test_the_horizon_grows_as_the_steps_do() -> None:
    steps = [0, 500, 999, 1_000, 2_000, 4_000, 8_000]
    found = gammas(0.98, 1_000, steps)
    assert found[:4] == [0.98] * 4
    for step, gamma in zip(steps[4:], found[4:], strict=True):
        # It is changed each time that the steps have grown by a tenth, so it lags behind by less.
        horizon = 1 / (1 - gamma)
        assert 50 * step / 1_000 / CHECKPOINT_GROWTH <= horizon <= 50 * step / 1_000 * (1 + 1e-9)


@pytest.mark.parametrize(("gamma", "ends"), [(0.98, 1 - 1 / LONGEST_HORIZON), (0.9999, 0.9999)])
def test_a_growing_horizon_has_an_end_and_never_shrinks(gamma: float, ends: float) -> None:
    found = gammas(gamma, 1_000, [1_000 * 2**power for power in range(12)])
    assert found == sorted(found) and found[-1] == pytest.approx(ends, abs=1e-12)


def test_rewards_are_measured_and_discounted_alike() -> None:
    """A change of the discount alone would shift all values, so both change at the same steps."""
    settings = replace(SETTINGS, horizon_growth_start=100, normalize_rewards=True)
    run = TrainingRun(CrossQ(settings), settings, ProbeEnv(), seed=1)
    measured, sampled = [], []
    scale, sample = run.buffer.measure_scale, run.buffer.sample

    def measure(gamma: float) -> None:
        measured.append(gamma)
        scale(gamma)

    def take(random, shape, gamma, n_steps):  # type: ignore[no-untyped-def]
        sampled.append((gamma, measured[-1]))
        return sample(random, shape, gamma, n_steps)

    run.buffer.measure_scale, run.buffer.sample = measure, take  # type: ignore[method-assign]
    while run.steps < 640:
        run.advance()
    assert len({one for one, _ in sampled}) > 3
    assert all(one == other for one, other in sampled)
