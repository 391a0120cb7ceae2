"""What is measured of a policy: each number against what one can work out by hand."""

from __future__ import annotations

from dataclasses import replace
from statistics import fmean

import numpy as np
import pytest

from robomore.evaluation.measure import choose, measure
from robomore.tasks import get_task
from robomore.training.policy import MLPPolicy

STEPS = 40
TASK = replace(get_task("half-cheetah"), episode_steps=STEPS)
OBSERVATIONS, ACTIONS = 17, 6


def pushing(force: float) -> MLPPolicy:
    """Return a policy that gives all motors the same action, whatever it sees."""
    weight = np.zeros((OBSERVATIONS, ACTIONS), np.float32)
    return MLPPolicy((weight,), (np.full(ACTIONS, force, np.float32),))


def test_fitness_is_the_mean_of_episodes_that_differ() -> None:
    found = measure(TASK, TASK.reference, pushing(0.3), 3, 5)
    assert len(set(found.episode_fitness)) == 3
    assert found.fitness == pytest.approx(fmean(found.episode_fitness))
    assert found.fitness != max(found.episode_fitness)
    assert found.behaviour["forward_distance_m"] == pytest.approx(found.fitness)


def test_speed_is_the_distance_over_the_time() -> None:
    behaviour = measure(TASK, TASK.reference, pushing(0.3), 2, 5).behaviour
    seconds = behaviour["episode_seconds"]
    assert seconds == pytest.approx(STEPS * 0.05)
    assert behaviour["forward_speed_m_s"] == pytest.approx(
        behaviour["forward_distance_m"] / seconds
    )


def test_a_gain_in_height_is_over_the_rest() -> None:
    behaviour = measure(TASK, TASK.reference, pushing(0.0), 1, 5).behaviour
    assert 0 <= behaviour["height_gain_m"] < 0.2 < behaviour["highest_torso_m"]


def test_motors_that_do_nothing_have_no_energy_and_saturation_is_of_each_episode() -> None:
    still = measure(TASK, TASK.reference, pushing(0.0), 2, 5).behaviour
    full = measure(TASK, TASK.reference, pushing(9.0), 3, 5).behaviour
    assert still["energy_j"] == 0.0 and still["saturated_share"] == 0.0
    assert full["energy_j"] > 0 and full["saturated_share"] == pytest.approx(1.0)


def test_the_best_policy_is_chosen_whatever_the_order() -> None:
    policies = {force: pushing(force) for force in (9.0, -9.0)}
    worth = {f: measure(TASK, TASK.reference, p, 3, 0).fitness for f, p in policies.items()}
    better, worse = sorted(policies, key=lambda force: -worth[force])
    assert abs(worth[better] - worth[worse]) > 0.1, "chance does not decide"
    for order in ((better, worse), (worse, better)):
        chosen = choose(TASK, TASK.reference, [policies[force] for force in order], 0)
        assert chosen is policies[better]
