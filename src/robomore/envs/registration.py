"""The tasks as Gymnasium environments: `gymnasium.make("robomore/Ant-v0", parameters=…)`.

Importing this module makes them known. `import robomore` does that as soon as Gymnasium is imported
too, and `gymnasium.make("robomore.envs.registration:robomore/Ant-v0")` by itself. Nothing else is
imported before an environment is made, so tasks of other packages are not loaded either.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from gymnasium.envs import registration

from robomore.registry import plugin_entries

if TYPE_CHECKING:
    import gymnasium

    from robomore.envs.robots.base import RewardFunction, RobotEnvironment
    from robomore.tasks.task import Task

ENVIRONMENTS = {
    "Ant": "ant",
    "AntPowered": "ant-powered",
    "AntDesert": "ant-desert",
    "AntJump": "ant-jump",
    "Hopper": "hopper",
    "HalfCheetah": "half-cheetah",
    "Swimmer": "swimmer",
    "Walker": "walker",
}
"""Gymnasium's name of each task."""

EPISODE_STEPS = 1000
"""Control steps after which Gymnasium cuts an episode off."""


def register() -> None:
    """Make `robomore/Ant-v0` and its like known to Gymnasium; calling it again does nothing.

    So are tasks of other packages: `hill-climb` is `robomore/HillClimb-v0`.
    """
    for name, task in ENVIRONMENTS.items():
        _register(name, task, "make_environment", EPISODE_STEPS)
    for entry in plugin_entries("robomore.tasks"):
        # How long its episodes are is only known once it is loaded.
        name = "".join(word[:1].upper() + word[1:] for word in re.split(r"\W+|_", entry.name))
        _register(name, entry.name, "make_limited_environment", None)


def _register(name: str, task: str, function: str, steps: int | None) -> None:
    id = f"robomore/{name}-v0"
    if name and id not in registration.registry:
        registration.register(
            id=id,
            entry_point=f"{__name__}:{function}",
            max_episode_steps=steps,
            kwargs={"task": task},
        )


def make_limited_environment(task: str, **options: Any) -> gymnasium.Env[Any, Any]:
    """Return what `make_environment` does, with episodes of the task's own length."""
    from gymnasium.wrappers import TimeLimit

    from robomore.tasks.registry import get_task

    return TimeLimit(make_environment(task, **options), get_task(task).episode_steps)


def make_environment(
    task: Task | str,
    parameters: Sequence[float] | Mapping[str, float] | str = "reference",
    reward: RewardFunction | str = "reference",
    render_mode: str | None = None,
    **options: Any,
) -> RobotEnvironment:
    """Return the environment of one morphology.

    Args:
        task: the task, or its id.
        parameters: in the task's order, by name, or `reference`.
        reward: a function `(self, x_velocity, action) -> (number, terms)`, the text of a module
            that defines `_get_rew`, or `reference`. Text is executed in this process.
        render_mode: as in Gymnasium.
        options: of the official class (`reset_noise_scale=…`).

    Raises:
        InputError: an unknown task, parameters that it refuses, or text that defines no reward.
    """
    from robomore.envs.reward_text import reward_function
    from robomore.envs.robots import environment_class
    from robomore.errors import InvalidMorphology
    from robomore.tasks.registry import get_task

    chosen = get_task(task) if isinstance(task, str) else task
    if isinstance(parameters, str):
        if parameters != "reference":
            raise InvalidMorphology(f"parameters are 'reference' or numbers, not {parameters!r}")
        parameters = chosen.reference
    if isinstance(reward, str):
        reward = reward_function(chosen.reward if reward == "reference" else reward)
    return environment_class(chosen)(chosen, parameters, reward, render_mode, **options)


register()
