"""What is measured of a policy: each number against what one can work out by hand."""

from __future__ import annotations

from dataclasses import replace
from statistics import fmean

import numpy as np
import pytest

from robomore.envs.compile import body_facts
from robomore.envs.measured_env import MeasuredEnv
from robomore.evaluation.measure import choose, measure
from robomore.tasks import Fitness, get_task
from robomore.training.policy import MLPPolicy
from robomore.transport import cost_of_transport

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


def test_height_and_distance_are_those_that_count(monkeypatch: pytest.MonkeyPatch) -> None:
    step = MeasuredEnv.step

    def throwing(env: MeasuredEnv, actions: np.ndarray) -> object:
        if env.elapsed[0] == 5:
            env.data[0].qvel[:3] = 9e5
        return step(env, actions)

    monkeypatch.setattr(MeasuredEnv, "step", throwing)
    task = replace(get_task("ant-jump"), episode_steps=STEPS)
    still = MLPPolicy((np.zeros((105, 8), np.float32),), (np.zeros(8, np.float32),))
    found = measure(task, task.reference, still, 1, 5)
    assert found.behaviour["fell_too_high_share"] == 1.0
    assert found.behaviour["highest_torso_m"] == found.fitness < 1
    assert abs(found.behaviour["forward_distance_m"]) < 0.1
    assert found.behaviour["height_gain_m"] < 0.3


def test_motors_that_do_nothing_have_no_energy_and_saturation_is_of_each_episode() -> None:
    still = measure(TASK, TASK.reference, pushing(0.0), 2, 5).behaviour
    full = measure(TASK, TASK.reference, pushing(9.0), 3, 5).behaviour
    assert still["energy_j"] == 0.0 and still["saturated_share"] == 0.0
    assert full["energy_j"] > 0 and full["saturated_share"] == pytest.approx(1.0)


@pytest.mark.parametrize(
    "parameters",
    [
        get_task("hopper").reference,
        (2.9, 2.0, 1.0, 0.1, -0.13, 0.26, 0.05, 0.05, 0.04, 0.06),
    ],
    ids=["reference", "tall"],
)
def test_a_hopper_that_only_falls_over_forward_transports_nothing(
    parameters: tuple[float, ...],
) -> None:
    """With next to no energy it gets farther than 1 m: an economy of 27 to 95, if it counted."""
    hopper = replace(get_task("hopper"), fitness=Fitness.of("transport-economy"))
    still = np.zeros((11, 3), np.float32)
    push = MLPPolicy((still,), (np.arctanh(np.full(3, 0.1, np.float32)),))
    found, body = measure(hopper, parameters, push, 2, 0), body_facts(hopper, parameters)
    distance, energy = (found.behaviour[one] for one in ("forward_distance_m", "energy_j"))
    assert distance > 1 and energy < 20
    assert found.fitness == 0.0
    assert cost_of_transport(distance, energy, body["mass"], body["rest_height"]) is None
    assert (cost_of_transport(distance, energy, body["mass"], 0.1) or 1) < 0.2


def test_the_best_policy_is_chosen_whatever_the_order() -> None:
    policies = {force: pushing(force) for force in (9.0, -9.0)}
    worth = {f: measure(TASK, TASK.reference, p, 3, 0).fitness for f, p in policies.items()}
    better, worse = sorted(policies, key=lambda force: -worth[force])
    assert abs(worth[better] - worth[worse]) > 0.1, "chance does not decide"
    for order in ((better, worse), (worse, better)):
        chosen = choose(TASK, TASK.reference, [policies[force] for force in order], 0)
        assert chosen is policies[better]
