"""A reward that a search starts from is tried out before anything is trained."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from robomore.errors import InputError, InvalidMorphology
from robomore.experiment import run
from robomore.experiment.starting import try_rewards
from robomore.sandbox.call import Containment
from robomore.settings import preset, with_method
from robomore.tasks import get_task
from robomore.types import Reward, Start

MISSPELT = """import numpy as np
def _get_rew(self, x_velocity, action):
    cost = np.sqare(action).sum()
    return x_velocity - cost, {"forward": x_velocity, "cost": -cost}
"""
ONE_TERM_IS_DEAD = """def _get_rew(self, x_velocity, action):
    return x_velocity, {"forward": x_velocity, "nothing": 0.0}
"""


def test_a_start_that_fails_as_it_runs_is_refused_before_anything_is_trained(
    tmp_path: Path,
) -> None:
    start = Start("mine.py", reward=Reward(MISSPELT))
    with pytest.raises(InputError, match=r"mine\.py: the reward .* line 3: .*sqare.*check-reward"):
        run("swimmer", "smoke", start_from=[start], out=tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_so_is_the_reward_of_the_method_given(tmp_path: Path) -> None:
    settings = with_method(preset("smoke"), "given", {"reward": MISSPELT})
    with pytest.raises(InputError, match=r"option `reward` of 'given'.* line 3: .*sqare"):
        run("swimmer", settings, out=tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_parameters_of_the_method_given_are_checked_before_there_is_a_folder(
    tmp_path: Path,
) -> None:
    settings = with_method(preset("smoke"), "given", {"parameters": [1, 2]})
    with pytest.raises(InvalidMorphology, match="swimmer"):
        run("swimmer", settings, out=tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_method_that_takes_no_reward_does_not_try_that_of_a_design(tmp_path: Path) -> None:
    task = get_task("swimmer")
    unused = Start("mine", reward=Reward(MISSPELT))
    settings = with_method(preset("smoke"), "random", {})
    # It is refused for another reason, and sooner.
    with pytest.raises(InputError, match="mine is a reward, and the method 'random' takes"):
        run(task, settings, start_from=[unused], out=tmp_path / "run")


def test_a_warning_is_told_and_the_task_s_own_reward_is_not_tried(
    caplog: pytest.LogCaptureFixture,
) -> None:
    task = get_task("swimmer")
    try_rewards(task, [("mine.py", ONE_TERM_IS_DEAD)], Containment.RELAXED)
    assert "mine.py, line 2: 'nothing' was 0 in all" in caplog.text
    own = replace(task, reward=MISSPELT)
    try_rewards(own, [("the task's", MISSPELT)], Containment.RELAXED)
