"""Noise that explores: standard normal at any time, and as slow as it is told to be."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from robomore.training.pink import PinkNoise


def drawn(octaves: int, steps: int) -> NDArray[np.float32]:
    random = np.random.default_rng(0)
    noise = PinkNoise(octaves, (40, 2), random)
    return np.stack([noise.draw(random) for _ in range(steps)])


def correlation(noise: NDArray[np.float32], lag: int) -> float:
    return float((noise[:-lag] * noise[lag:]).mean() / np.square(noise).mean())


@pytest.mark.parametrize("octaves", [1, 4, 6])
def test_it_is_standard_normal_at_any_time(octaves: int) -> None:
    settled = drawn(octaves, 3_000)[200:]
    assert settled.mean() == pytest.approx(0, abs=0.05)
    assert settled.std() == pytest.approx(1, abs=0.05)
    assert np.mean(np.abs(settled) < 1) == pytest.approx(0.683, abs=0.02)


def test_one_octave_is_white() -> None:
    assert correlation(drawn(1, 3_000), 1) == pytest.approx(0, abs=0.02)


def test_power_falls_with_frequency_as_one_over_it() -> None:
    power = np.square(np.abs(np.fft.rfft(drawn(6, 4_096), axis=0))).mean(axis=(1, 2))
    # Between what the longest and what the shortest memory can tell apart.
    frequencies = np.arange(4_096 // 64, 4_096 // 4)
    slope, _ = np.polyfit(np.log(frequencies), np.log(power[frequencies]), 1)
    assert slope == pytest.approx(-1, abs=0.3)


def test_the_first_steps_are_no_quieter() -> None:
    assert drawn(6, 2).std() == pytest.approx(1, abs=0.15)
