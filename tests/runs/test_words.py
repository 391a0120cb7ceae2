"""Numbers and their names as people read them."""

from __future__ import annotations

import numpy as np
import pytest

from robomore.envs.vector_env import VectorEnv
from robomore.evaluation.measure import measure
from robomore.runs.words import LABELS, duration, in_unit, label, measured, number
from robomore.tasks import get_task
from robomore.training.policy import MLPPolicy


def test_every_number_that_is_measured_has_a_label() -> None:
    task = get_task("swimmer")
    simulations = VectorEnv(task, task.reference, 1)
    size = simulations.observation_size, simulations.action_size
    still = MLPPolicy((np.zeros(size, np.float32),), (np.zeros(size[1], np.float32),))
    found = measure(task, task.reference, still, 1, 0).behaviour
    assert found
    assert set(found) <= set(LABELS)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("forward_speed_m_s", "forward speed (m/s)"),
        ("fell_share", "episodes that ended in a fall"),
        ("stride_length_m", "stride length (m)"),
        ("stance_seconds", "stance (s)"),
        ("symmetry", "symmetry"),
    ],
)
def test_unknown_names_are_put_into_words(name: str, said: str) -> None:
    assert label(name) == said


def test_a_share_is_told_in_percent() -> None:
    assert measured("fell_share", 0.125) == "12.5 %"
    assert measured("fell_share", 0.0) == "0 %"
    assert measured("forward_speed_m_s", 0.125) == "0.1250"
    assert measured("fell_share", None) == "-"


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (12_345.6, "12,350"),
        (0.0, "0"),
        (None, "-"),
        (float("nan"), "-"),
        (-0.0123456, "-0.01235"),
        (3.17e67, "3.170e+67"),
    ],
)
def test_numbers_have_four_digits(value: float | None, said: str) -> None:
    assert number(value) == said


def test_durations_are_told_as_people_say_them() -> None:
    assert [duration(s) for s in (42.0, 200.0, 7_500.0)] == ["42 s", "3 min 20 s", "2 h 05 min"]


def test_a_score_has_its_unit_or_its_name() -> None:
    assert in_unit(2.0, "efficiency", "m") == "2.000 m/m³"
    assert in_unit(2.0, "efficiency", "") == "2.000 1/m³"
    assert in_unit(2.0, "fitness", "m/J") == "2.000 m/J"
    assert in_unit(2.0, "fitness", "") == "2.000 (fitness)"
    assert in_unit(2.0, "transport-economy", "m") == "2.000 (transport economy)"
