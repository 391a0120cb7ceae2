"""Robots that cheat: each has one fault of the simulation planted in an honest task."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from robomore.audit import Subject
from robomore.envs.vector_env import VectorEnv
from robomore.tasks import Task, get_task
from robomore.training.policy import MLPPolicy

_FLOOR = '<geom name="floor" '


def short(task: str, steps: int = 100) -> Task:
    """Return a task with short episodes."""
    return replace(get_task(task), episode_steps=steps)


def bouncy_ground(task: Task, solref: str) -> Task:
    """Return the task on a ground that gives back more than it takes."""
    ground = f'{_FLOOR}priority="1" solref="{solref}" solimp="0.95 0.99 0.001" '
    template = task.template.replace(_FLOOR, ground)
    flag = '  <option><flag refsafe="disable"/></option>\n  <default>'
    return replace(task, template=template.replace("  <default>", flag, 1))


def through_the_floor(task: Task) -> Task:
    """Return Half-Cheetah with feet that the ground does not hold."""
    return replace(
        task, template=re.sub(r'(<geom name="[bf]foot")', r'\1 contype="0"', task.template)
    )


def still(task: Task, episodes: int = 1) -> Subject:
    """Return the task's reference robot with motors that do nothing."""
    env = VectorEnv(task, task.reference, 1)
    shape = env.observation_size, env.action_size
    policy = MLPPolicy((np.zeros(shape, np.float32),), (np.zeros(shape[1], np.float32),))
    return Subject(task, task.reference, policy, episodes=episodes)


def restless(task: Task, **options: object) -> Subject:
    """Return the task's reference robot with a policy that nobody trained."""
    env = VectorEnv(task, task.reference, 1)
    shape = env.observation_size, env.action_size
    weights = np.random.default_rng(1).normal(size=shape).astype(np.float32)
    policy = MLPPolicy((weights,), (np.zeros(shape[1], np.float32),))
    return Subject(task, task.reference, policy, episodes=1, **options)  # type: ignore[arg-type]
