from __future__ import annotations

import time
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from designers.evaluations import EACH_TASK
from robomore.designers.offline.designer import OfflineDesigner
from robomore.errors import ProposalFailed
from robomore.search.random import drawn
from robomore.tasks.geometry import Solid
from robomore.tasks.registry import TASKS
from robomore.tasks.task import Rule
from robomore.tasks.unit_space import UnitSpace, distances
from robomore.types import Morphology, Slot

COUNT = 25


def slot(index: int, attempt: int = 0) -> Slot:
    return Slot("coarse", "morphology", (index,), attempt=attempt)


@cache
def designer(task: str) -> OfflineDesigner:
    return OfflineDesigner(TASKS[task], seed=3)


@cache
def proposals(task: str) -> tuple[Morphology, ...]:
    bodies: list[Morphology] = []
    for index in range(COUNT):
        bodies.append(designer(task).propose_morphology(slot(index), bodies))
    return tuple(bodies)


def nearest(bodies: np.ndarray, space: UnitSpace) -> float:
    apart = distances(space.units(bodies), space.units(bodies))
    return float(apart[~np.eye(len(bodies), dtype=bool)].min())


def variation(bodies: np.ndarray) -> float:
    """The paper's diversity: mean over parameters of standard deviation over mean size."""
    mean = np.abs(bodies.mean(axis=0))
    return float(np.mean(bodies.std(axis=0)[mean > 0] / mean[mean > 0]))


@pytest.mark.parametrize("task", EACH_TASK)
def test_bodies_are_valid_light_and_described(task: str) -> None:
    known = TASKS[task]
    bodies = proposals(task)
    for body in bodies:
        assert known.check(body.parameters) == body.parameters
        assert "m³" in body.idea
    volumes = [known.volume(body.parameters) for body in bodies]
    assert np.median(volumes) < known.volume(known.reference) / 3
    # The first few decide a short run.
    assert min(volumes[:5]) < known.volume(known.reference) / 5


@pytest.mark.parametrize("task", EACH_TASK)
def test_bodies_are_farther_apart_than_random_ones(task: str) -> None:
    space = UnitSpace(TASKS[task])
    ours = np.array([body.parameters for body in proposals(task)])
    random = np.array([drawn(TASKS[task], seed, 0.5).parameters for seed in range(COUNT)])
    assert nearest(ours, space) > 1.1 * nearest(random, space)
    assert variation(ours) > 1.1 * variation(random)


def test_a_proposal_depends_on_its_arguments_alone() -> None:
    bodies = proposals("hopper")
    fresh = OfflineDesigner(TASKS["hopper"], seed=3)
    assert fresh.propose_morphology(slot(7), bodies[:7]) == bodies[7]
    assert fresh.propose_morphology(slot(2), bodies[:2]) == bodies[2]
    other = OfflineDesigner(TASKS["hopper"], seed=4)
    assert other.propose_morphology(slot(0), ()) != bodies[0]


def test_a_second_attempt_is_another_body() -> None:
    bodies = proposals("hopper")[:3]
    made = {designer("hopper").propose_morphology(slot(3, attempt), bodies) for attempt in range(6)}
    assert len(made) > 1


def test_a_proposal_takes_milliseconds() -> None:
    bodies = proposals("ant")  # makes the pool, once
    began = time.process_time()
    for index in range(10):
        designer("ant").propose_morphology(slot(index), bodies)
    assert (time.process_time() - began) / 10 < 0.05


def test_impossible_rules_are_a_failed_proposal() -> None:
    never = Rule("never", lambda values: "it never is")
    task = replace(TASKS["swimmer"], rules=(never,))
    with pytest.raises(ProposalFailed, match="0 pass its rules"):
        OfflineDesigner(task, seed=0).propose_morphology(slot(0), ())


def test_a_robot_whose_pose_cannot_be_read_still_gets_bodies() -> None:
    swimmer = TASKS["swimmer"]
    template = swimmer.template.replace('<body name="mid"', '<body quat="1 0 0 0" name="mid"')
    assert template != swimmer.template
    task = replace(swimmer, template=template)
    body = OfflineDesigner(task, seed=0).propose_morphology(slot(0), ())
    assert task.check(body.parameters)


def test_a_robot_without_capsules_is_described_by_its_volume() -> None:
    boxes = replace(TASKS["swimmer"], shapes=lambda values: [Solid(0.01 * values["front_length"])])
    said = OfflineDesigner(boxes, seed=0).propose_morphology(slot(0), ()).idea
    assert said.startswith("volume ") and "limb" not in said
    assert "reference" not in said, "a designer does not see it"
