"""The five robots as Gymnasium environments: the official v5 classes with free dimensions.

Each class keeps its official observation, reset and step, and adds the same facts for a whole batch
of simulations at once, which `robomore.envs.vector_env` is built on.
"""

from __future__ import annotations

from importlib import import_module

from robomore.envs.robots.base import RobotEnvironment
from robomore.tasks.task import Task


def environment_class(task: Task) -> type[RobotEnvironment]:
    """Return the class that `task.environment` (`module:Class`) names.

    Raises:
        TypeError: it names something else than a `RobotEnvironment`.
    """
    module, _, name = task.environment.partition(":")
    found = getattr(import_module(module), name)
    if not (isinstance(found, type) and issubclass(found, RobotEnvironment)):
        raise TypeError(f"{task.id}: {task.environment} is not a RobotEnvironment")
    return found


__all__ = ["RobotEnvironment", "environment_class"]
