"""Which changes make another evaluation, and which leave it what it was."""

from __future__ import annotations

from dataclasses import replace

import pytest

from robomore.identity import job_key, training_key
from robomore.types import Design, Job, Limits, Morphology, Reward, TrainerSettings

DESIGN = Design(Morphology((0.1, 0.2), "thin"), Reward("def _get_rew(): ...", "fast"))
JOB = Job("ant", DESIGN, TrainerSettings("crossq", {"gamma": 0.99}), 100, 2, 7, task_key="t1")
VERSIONS = {"robomore": "1", "mujoco": "3"}

TRAINING = {
    "task": replace(JOB, task="ant-jump"),
    "edited task": replace(JOB, task_key="t2"),
    "morphology": replace(JOB, design=replace(DESIGN, morphology=Morphology((0.1, 0.3)))),
    "reward": replace(JOB, design=replace(DESIGN, reward=Reward("def _get_rew(): pass"))),
    "trainer": replace(JOB, trainer=TrainerSettings("sac", {"gamma": 0.99})),
    "settings": replace(JOB, trainer=TrainerSettings("crossq", {"gamma": 0.98})),
    "seed": replace(JOB, seed=8),
}
MEASUREMENT = {"steps": replace(JOB, steps=200), "episodes": replace(JOB, episodes=3)}
NOTHING = {
    "limits": replace(JOB, limits=Limits(wall_seconds=1)),
    "ideas": replace(
        JOB,
        design=Design(Morphology((0.1, 0.2), "other"), Reward("def _get_rew(): ...", "words")),
    ),
}


@pytest.mark.parametrize("job", [*TRAINING.values()], ids=[*TRAINING])
def test_another_training_is_another_evaluation(job: Job) -> None:
    assert training_key(job, VERSIONS) != training_key(JOB, VERSIONS)
    assert job_key(job, VERSIONS) != job_key(JOB, VERSIONS)


@pytest.mark.parametrize("job", [*MEASUREMENT.values()], ids=[*MEASUREMENT])
def test_more_of_the_same_training_goes_on_with_it(job: Job) -> None:
    assert training_key(job, VERSIONS) == training_key(JOB, VERSIONS)
    assert job_key(job, VERSIONS) != job_key(JOB, VERSIONS)


@pytest.mark.parametrize("job", [*NOTHING.values()], ids=[*NOTHING])
def test_what_changes_no_number_changes_no_key(job: Job) -> None:
    assert training_key(job, VERSIONS) == training_key(JOB, VERSIONS)
    assert job_key(job, VERSIONS) == job_key(JOB, VERSIONS)


def test_another_version_may_give_other_numbers() -> None:
    newer = {**VERSIONS, "mujoco": "4"}
    assert training_key(JOB, newer) != training_key(JOB, VERSIONS)
    assert job_key(JOB, newer) != job_key(JOB, VERSIONS)
