"""Fitness curves: train a design in this process, and measure the policy at some steps on the way.

What is measured at a number of steps is what an evaluation with that budget would give: nothing in
our trainers depends on the budget, so a longer training passes through the shorter ones.
"""

from __future__ import annotations

import json
import math
import multiprocessing
import os
import time
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from robomore.envs.reward_text import reward_function
from robomore.envs.vector_env import VectorEnv
from robomore.errors import TrainingDiverged, UnstableSimulation
from robomore.evaluation.measure import choose, measure
from robomore.identity import derive_seed
from robomore.tasks import get_task
from robomore.tasks.task import Task
from robomore.training.loop import TrainingRun
from robomore.training.settings import make_trainer, settings_from
from robomore.training.threads import ONE_THREAD
from robomore.training.tuned import resolve
from robomore.types import TrainerSettings

HUMAN_FITNESS = {
    "ant": 12.43,
    "hopper": 6.86,
    "half-cheetah": 253.69,
    "swimmer": 2.01,
    "walker": 4.78,
}
"""The paper's Human row (its Table 2), in m."""

SLIM = 0.4
"""Radii of the slim morphologies, as a fraction of the human ones."""

EPISODES = 10


@dataclass(frozen=True)
class Course:
    """A training to be done.

    Attributes:
        robot: task whose robot this is.
        morphology: name of the morphology.
        parameters: of the morphology, in the task's order.
        seed: of the training.
        trainer: with the options that are asked for; the robot's tuned ones are put in.
        steps: control steps in all.
        every: control steps between two measurements.
        reward: source text; empty for the reference reward.
        until: fitness in m that ends it early.
        label: what tells it apart from others, if the rest does not.
    """

    robot: str
    morphology: str
    parameters: tuple[float, ...]
    seed: int
    trainer: TrainerSettings
    steps: int
    every: int
    reward: str = ""
    until: float = math.inf
    label: str = ""


@dataclass(frozen=True)
class Mark:
    """What a training had come to.

    Attributes:
        robot, morphology, seed: whose it is.
        steps: control steps done.
        seconds: core-seconds of training, neither compiling nor measuring.
        fitness: in m, over episodes of their own.
        longest: mean length of those episodes, in s.
        label: of the course.
    """

    robot: str
    morphology: str
    seed: int
    steps: int
    seconds: float
    fitness: float
    longest: float
    label: str = ""


def parameters_of(robot: str, morphology: str) -> tuple[float, ...]:
    """Return the human morphology, or a slim one: its radii cut to `SLIM`, within bounds."""
    task = get_task(robot)
    if morphology == "human":
        return task.reference
    return task.check(
        [
            max(p.low, SLIM * p.reference) if p.name.endswith("_radius") else p.reference
            for p in task.parameters
        ]
    )


def open_trainer(
    task: Task, parameters: tuple[float, ...], trainer: TrainerSettings, reward: str = ""
) -> tuple[Any, VectorEnv]:
    """Return a trainer and what it trains in: as in an evaluation, but without a sandbox."""
    trainer = resolve(trainer, task)
    settings = settings_from(trainer)
    environment = VectorEnv(
        task,
        parameters,
        settings.num_envs,
        reward_function(reward or task.reward),
        episode_seconds=settings.episode_seconds,
        replace_rk4=settings.replace_rk4,
    )
    return make_trainer(trainer), environment


def follow(course: Course) -> list[Mark]:
    """Train along `course` and return what was measured."""
    task, parameters = get_task(course.robot), course.parameters
    trainer, environment = open_trainer(task, parameters, course.trainer, course.reward)
    trainer.prepare(environment.observation_size, environment.action_size)
    seed = derive_seed(course.seed, course.robot, course.morphology)
    run = TrainingRun(trainer, trainer.settings, environment, seed)
    marks, seconds = [], 0.0
    try:
        while run.steps < course.steps:
            began = time.process_time()
            due = (run.steps // course.every + 1) * course.every
            while run.steps < min(due, course.steps):
                run.advance()
            seconds += time.process_time() - began
            policy = choose(task, parameters, run.policies(), seed)
            found = measure(task, parameters, policy, EPISODES, seed)
            length = found.behaviour["episode_seconds"]
            marks.append(
                Mark(
                    course.robot,
                    course.morphology,
                    course.seed,
                    run.steps,
                    seconds,
                    found.fitness,
                    length,
                    course.label,
                )
            )
            if found.fitness >= course.until:
                break
    except (TrainingDiverged, UnstableSimulation) as error:
        print(f"{course.robot} {course.morphology} seed {course.seed}: {error}", flush=True)
    return marks


def follow_all(courses: Iterable[Course], workers: int, out: Path | None) -> Iterator[list[Mark]]:
    """Yield the marks of each course as it ends, in no particular order, and keep them in `out`."""
    os.environ.update(ONE_THREAD)
    with multiprocessing.get_context("spawn").Pool(workers, maxtasksperchild=1) as pool:
        for marks in pool.imap_unordered(follow, courses, chunksize=1):
            if out is not None:
                with out.open("a") as file:
                    file.writelines(json.dumps(asdict(mark)) + "\n" for mark in marks)
            yield marks


def spread(fitness: Iterable[float]) -> float:
    """Return the coefficient of variation over seeds: sample deviation / mean."""
    values = np.array(list(fitness))
    if len(values) < 2 or not values.mean():
        return float("nan")
    return float(values.std(ddof=1) / abs(values.mean()))
