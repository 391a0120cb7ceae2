"""The contract check passes the paper's tasks, and finds each fault."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.task_file import read_task
from robomore.tasks import Parameter, Task, get_task
from robomore.testing import tasks as module
from robomore.testing.tasks import check_task
from tripod import TRIPOD, write_tripod

SWIMMER = get_task("swimmer")


@pytest.mark.parametrize("task", ["swimmer", "half-cheetah", "ant-desert"])
def test_the_paper_s_tasks_keep_the_contract(task: str) -> None:
    check_task(get_task(task))


FILLED = SWIMMER.mjcf(SWIMMER.reference)


def first(**changes: Any) -> Task:
    parameter: Parameter = replace(SWIMMER.parameters[0], **changes)
    parameters = (parameter, *SWIMMER.parameters[1:])
    return replace(SWIMMER, parameters=parameters, template=FILLED, shapes=SWIMMER.solids)


@pytest.mark.parametrize(
    ("task", "said"),
    [
        (replace(SWIMMER, parameters=(), template=FILLED), "at least one free parameter"),
        (first(name=SWIMMER.parameters[1].name), "two parameters have one name"),
        (first(low=9.0), "low has to be below high"),
        (first(reference=-1.0), "outside its bounds"),
        (first(meaning=""), "no meaning"),
        (replace(SWIMMER, shapes=lambda values: ()), "no volume"),
        (
            # The second and third segment are forgotten.
            replace(SWIMMER, shapes=lambda values: SWIMMER.solids(values)[:1]),
            "`shapes` have .* m³ and the robot's solids .* m³",
        ),
        (
            replace(SWIMMER, template=SWIMMER.template.partition("<actuator>")[0] + "</mujoco>"),
            "no motors",
        ),
        (
            replace(SWIMMER, reward="def _get_rew(self, v, a):\n    return float('nan'), {}\n"),
            "must be finite",
        ),
    ],
)
def test_each_fault_is_found(task: Task, said: str) -> None:
    with pytest.raises(Exception, match=said):
        check_task(task)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        # The front link's volume stands still, which no look at the reference shows.
        (
            {"shapes": lambda values: SWIMMER.solids(values | {"front_radius": 0.1})},
            r"`shapes` have .* with front_length = .*leave `shapes` out",
        ),
        # What MuJoCo makes of this element is not read.
        (
            {
                "template": re.sub(
                    r'(<geom name="back_geom".*/>)',
                    r"<replicate count='2'>\1</replicate>",
                    SWIMMER.template,
                )
            },
            r"template is read as .* give `shapes`",
        ),
    ],
)
def test_a_volume_is_that_of_the_compiled_robot_beside_the_reference_too(
    changes: dict[str, Any], said: str
) -> None:
    with pytest.raises(AssertionError, match=said):
        check_task(replace(SWIMMER, **changes))


def test_a_robot_beside_the_reference_that_diverges_is_named_with_the_same_remedies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    source = write_tripod(tmp_path, TRIPOD)
    task = read_task(write_proposal(read_robot(source), source, tmp_path / "made"))
    monkeypatch.setattr(module, "try_out", lambda task, parameters: None)
    said = r"the robot with thigh_length = 0\.\d+, .*: The physics diverged .*motors\. .* armature"
    with pytest.raises(AssertionError, match=said):
        check_task(task)
    assert not (tmp_path / "MUJOCO_LOG.TXT").exists()
