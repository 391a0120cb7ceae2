"""Learning curves: what a point holds, how many there are, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from probes import SETTINGS

from robomore.testing.probe_env import ProbeEnv
from robomore.training.crossq import CrossQ
from robomore.training.curve import MOST_POINTS, CurveRecorder, check_curve
from robomore.training.loop import TrainingRun
from robomore.training.trainer import Transition
from robomore.types import Curve

N = ProbeEnv.num_envs


class Terms(ProbeEnv):
    """Says of its terms what it is told to."""

    sums: dict[str, tuple[int, float]]

    def reward_sums(self) -> dict[str, tuple[int, float]]:
        return self.sums


def step(reward: float, ended: list[int]) -> Transition:
    """Return one control step: the reward of all environments, and which episodes ended."""
    terminated = np.isin(np.arange(N), ended)
    nothing = np.zeros((N, 2))
    return Transition(nothing, np.full(N, reward), terminated, np.zeros(N, np.bool_), nothing)


def test_a_point_holds_means_over_what_happened_since_the_point_before() -> None:
    environment, recorder = Terms(), CurveRecorder(N)
    environment.sums = {"forward": (8, 4.0)}
    recorder.note_step(step(1.0, []))
    recorder.note_step(step(2.0, [0, 1]))
    recorder.note_round(2 * N, {}, environment)
    environment.sums = {"forward": (16, 20.0), "effort": (4, -2.0)}
    recorder.note_step(step(5.0, [0]))
    recorder.note_step(step(0.5, [2]))
    recorder.note_round(4 * N, {"loss/critic": 3.0, "alpha": 0.1}, environment)
    assert recorder.curve(4 * N, environment) == Curve(
        (8, 16),
        {
            # The first two episodes: 1 + 2. Then 5, and 1 + 2 + 5 + 0.5.
            "episode_return": (3.0, 6.75),
            "episode_length": (2.0, 2.5),
            "term/forward": (0.5, 2.0),
            "term/effort": (None, -0.5),
            "loss/critic": (None, 3.0),
            "alpha": (None, 0.1),
        },
    )


def rounds(recorder: CurveRecorder, environment: Terms, first: int, last: int) -> None:
    """Play rounds of one step, in each of which one episode ends and one term is its number."""
    for number in range(first, last):
        recorder.note_step(step(float(number), [number % N]))
        count, total = environment.sums["a"]
        environment.sums = {"a": (count + 1, total + number)}
        recorder.note_round((number + 1) * N, {"loss/critic": float(number)}, environment)


def fresh() -> tuple[CurveRecorder, Terms]:
    environment = Terms()
    environment.sums = {"a": (0, 0.0)}
    return CurveRecorder(N), environment


@pytest.mark.parametrize("count", [1, 63, 64, 65, 127, 128, 1_000, 5_000])
def test_a_curve_has_a_bounded_number_of_points_and_loses_nothing(count: int) -> None:
    recorder, environment = fresh()
    rounds(recorder, environment, 0, count)
    curve = recorder.curve(count * N, environment)
    check_curve(curve)
    assert min(count, MOST_POINTS // 2) <= len(curve.steps) <= MOST_POINTS
    assert curve.steps[-1] == count * N
    sizes = np.diff([0, *curve.steps]) / N
    assert len(set(sizes[:-1])) <= 1
    for name in ("term/a", "loss/critic"):
        assert np.dot(sizes, curve.series[name]) == pytest.approx(sum(range(count)))


@pytest.mark.parametrize("first", [1, 40, 64, 150, 333])
def test_looking_and_stopping_on_the_way_change_nothing(first: int) -> None:
    uninterrupted, environment = fresh()
    rounds(uninterrupted, environment, 0, 400)
    expected = uninterrupted.curve(400 * N, environment)

    recorder, environment = fresh()
    rounds(recorder, environment, 0, first)
    recorder.curve(first * N, environment)
    facts, arrays = recorder.state()
    continued = CurveRecorder(N)
    continued.restore(facts, arrays)
    rounds(continued, environment, first, 400)
    assert continued.curve(400 * N, environment) == expected


def test_a_number_that_is_not_finite_becomes_no_value() -> None:
    recorder, environment = fresh()
    environment.sums = {"a": (3, float("inf"))}
    recorder.note_round(N, {"loss/critic": float("nan")}, environment)
    assert recorder.curve(N, environment).series == {"term/a": (None,), "loss/critic": (None,)}


def test_names_are_cut_to_the_bound() -> None:
    recorder, environment = fresh()
    environment.sums = {"x" * 1_000: (1, 1.0)}
    recorder.note_round(N, {}, environment)
    check_curve(recorder.curve(N, environment))


def test_training_records_everything() -> None:
    environment = ProbeEnv()
    run = TrainingRun(CrossQ(SETTINGS), SETTINGS, environment, seed=1)
    while run.steps < 512:
        run.advance()
    curve = run.result().curve
    assert curve is not None
    check_curve(curve)
    assert list(curve.steps) == list(range(16, 513, 16))
    series = curve.series
    assert set(series) == {
        "episode_return",
        "episode_length",
        "term/reward",
        "loss/critic",
        "loss/actor",
        "alpha",
    }
    assert {value for value in series["episode_length"] if value is not None} == {5.0}
    # Learning starts once the first 128 steps are there.
    begins = 128 // 16 - 1
    for name in ("loss/critic", "loss/actor", "alpha"):
        assert all(value is None for value in series[name][:begins])
        assert all(value is not None for value in series[name][begins:])
    terms = [value for value in series["term/reward"] if value is not None]
    count, total = environment.reward_sums()["reward"]
    assert np.mean(terms) == pytest.approx(total / count)


BAD: dict[str, Any] = {
    "too many": Curve(tuple(range(1, 66)), {}),
    "too many or": Curve((1,), {f"term/{i}": (0.0,) for i in range(65)}),
    "too long": Curve((1,), {"x" * 101: (0.0,)}),
    "do not rise": Curve((1, 1), {}),
    "do not rise ": Curve((0, 1), {}),
    "another length": Curve((1, 2), {"a": (0.0,)}),
    "not finite": Curve((1,), {"a": (float("nan"),)}),
}


@pytest.mark.parametrize("curve", BAD.values(), ids=BAD)
def test_a_curve_beyond_the_bounds_is_refused(curve: Curve) -> None:
    good = Curve((1, 2), {f"term/{i}": (None, 0.5) for i in range(64)} | {"alpha": (0.1, None)})
    check_curve(good)
    check_curve(replace(good, steps=(), series={"a": ()}))
    with pytest.raises(ValueError, match="learning curve"):
        check_curve(curve)
