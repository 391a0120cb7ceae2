"""What each robot's trainer is given, and that what was asked for wins."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from robomore.envs.vector_env import VectorEnv
from robomore.errors import InputError
from robomore.tasks import TASKS, get_task
from robomore.training.settings import settings_from
from robomore.training.tuned import ensure_tuned, resolve, tuned
from robomore.types import TrainerSettings

EFFECTIVE = {
    "ant": (0.995, 0.5),
    "ant-powered": (0.995, 0.5),
    "ant-desert": (0.995, 0.5),
    "ant-jump": (0.995, 0.5),
    "hopper": (0.99, 0.0),
    "half-cheetah": (0.99, 0.5),
    "swimmer": (0.999, 0.5),
    "walker": (0.99, 0.0),
}
"""`gamma` and `deterministic_env_fraction` of CrossQ."""


@pytest.mark.parametrize("task", EFFECTIVE)
def test_each_task_is_trained_with_its_robots_options(task: str) -> None:
    found = settings_from(resolve(TrainerSettings("crossq"), get_task(task)))
    assert (found.gamma, found.deterministic_env_fraction) == EFFECTIVE[task]


def test_every_task_is_covered() -> None:
    assert set(EFFECTIVE) <= set(TASKS)


@pytest.mark.parametrize("task", EFFECTIVE)
@pytest.mark.parametrize("trainer", ["sac", "sb3"])
def test_the_papers_algorithm_keeps_the_papers_settings(trainer: str, task: str) -> None:
    asked = TrainerSettings(trainer, {"learning_rate": 1e-4})
    assert resolve(asked, get_task(task)) == asked


def test_explicit_options_win() -> None:
    asked = TrainerSettings("crossq", {"gamma": 0.9, "batch_size": 64})
    found = resolve(asked, get_task("ant"))
    assert found.options == tuned("crossq", get_task("ant")) | {"gamma": 0.9, "batch_size": 64}
    assert resolve(found, get_task("ant")) == found


def test_networks_of_ants_see_all_but_the_contact_forces() -> None:
    environment = VectorEnv(get_task("ant"), get_task("ant").reference, 1)
    forces = environment.model.nbody - 1
    seen = settings_from(resolve(TrainerSettings("crossq"), get_task("ant"))).observed
    assert seen == environment.observation_size - 6 * forces


def test_a_task_of_ones_own_gets_the_options_of_the_robot_that_it_uses() -> None:
    ant = get_task("ant")
    assert tuned("crossq", replace(ant, id="ant-on-ice")) == tuned("crossq", ant)
    assert tuned("crossq", replace(ant, environment="elsewhere:Robot")) == {}
    longer = replace(ant, template=ant.template + '<joint type="hinge"/>')
    assert "observed" in tuned("crossq", ant) and "observed" not in tuned("crossq", longer)
    assert tuned("mine", ant) == {}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            {"n_critics": 1},
            r"n_critics=2 too, .*\(min_q_weight = -0.5 is tuned for ant, not given\)",
        ),
        ({"normalize_rewards": False}, r"\(num_bins = 101 is tuned for ant, not given\)"),
        ({"min_q_weight": 2}, r"at most 1$"),
    ],
)
def test_what_clashes_with_a_tuned_option_is_refused_and_the_option_is_named(
    options: dict[str, Any], said: str
) -> None:
    with pytest.raises(InputError, match=said):
        ensure_tuned(TrainerSettings("crossq", options), get_task("ant"))


def test_what_fits_a_tuned_option_is_taken() -> None:
    ensure_tuned(TrainerSettings("crossq", {"min_q_weight": 1}), get_task("ant"), 20_000)
    with pytest.raises(InputError, match="n_critics is 1; give n_critics=2 too, or min_q_weight=0"):
        ensure_tuned(TrainerSettings("crossq", {"min_q_weight": 1}), get_task("hopper"))
