"""The tasks as Gymnasium environments: `gymnasium.make("robomore/Ant-v0", parameters=…)`.

Importing this module makes them known, as Gymnasium expects of a package; by name alone,
`gymnasium.make("robomore.envs.registration:robomore/Ant-v0")` does so itself. Nothing else is
imported before an environment is made.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from gymnasium.envs import registration

if TYPE_CHECKING:
    from robomore.envs.robots.base import RewardFunction, RobotEnvironment

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
    """Make `robomore/Ant-v0` and its like known to Gymnasium; calling it again does nothing."""
    for name, task in ENVIRONMENTS.items():
        id = f"robomore/{name}-v0"
        if id not in registration.registry:
            registration.register(
                id=id,
                entry_point=f"{__name__}:make_environment",
                max_episode_steps=EPISODE_STEPS,
                kwargs={"task": task},
            )


def make_environment(
    task: str,
    parameters: Sequence[float] | Mapping[str, float] | str = "reference",
    reward: RewardFunction | str = "reference",
    render_mode: str | None = None,
    **options: Any,
) -> RobotEnvironment:
    """Return the environment of one morphology.

    Args:
        task: id of the task.
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

    chosen = get_task(task)
    if isinstance(parameters, str):
        if parameters != "reference":
            raise InvalidMorphology(f"parameters are 'reference' or numbers, not {parameters!r}")
        parameters = chosen.reference
    if isinstance(reward, str):
        reward = reward_function(chosen.reward if reward == "reference" else reward)
    return environment_class(chosen)(chosen, parameters, reward, render_mode, **options)


register()
