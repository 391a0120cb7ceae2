"""Tasks: a robot with free dimensions, and what it is to do.

A task is one frozen value in one file: its description in words, the MJCF template of its robot,
the parameters that fill the template, the rules between them, the solids that make up its volume,
the reference reward and the environment. Reading a task, checking parameters and computing a volume
need no simulator; `robomore.envs.compile` turns parameters into a MuJoCo model.
"""

from __future__ import annotations

from robomore.tasks.fitness import Fitness
from robomore.tasks.geometry import Capsule, Shape, Sphere
from robomore.tasks.measures import MEASURES, FitnessMeasure
from robomore.tasks.registry import TASKS, get_task
from robomore.tasks.task import Parameter, Rule, Task, Terrain, Values
from robomore.tasks.trajectory import Trajectory

__all__ = [
    "MEASURES",
    "TASKS",
    "Capsule",
    "Fitness",
    "FitnessMeasure",
    "Parameter",
    "Rule",
    "Shape",
    "Sphere",
    "Task",
    "Terrain",
    "Trajectory",
    "Values",
    "get_task",
]
