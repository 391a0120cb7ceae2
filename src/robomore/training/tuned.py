"""Tuned options: what a trainer needs to be told about a robot, as opposed to about a task.

They were found by learning curves of the human designs (`benchmarks/README.md`). A robot that has
none is trained with the trainer's defaults.
"""

from __future__ import annotations

import re
from typing import Any

from robomore.errors import InputError
from robomore.tasks import Task
from robomore.training.settings import ensure_trainer
from robomore.types import TrainerSettings

_TUNED: dict[str, dict[str, dict[str, Any]]] = {
    "crossq": {
        # An ant that learns well soon learns to stand still, which costs nothing. Held noise and
        # optimism together bring it out of that. Contact forces begin with the 28th number. Many
        # gradient steps on small batches cost what few cost on large ones, and teach it no worse.
        "robomore.envs.robots.ant:AntEnvironment": {
            "gamma": 0.995,
            "batch_size": 64,
            "gradient_steps": 28,
            "deterministic_env_fraction": 0.5,
            "max_noise_repeat": 16,
            "observed": 27,
            "n_critics": 2,
            "min_q_weight": -0.5,
            "num_bins": 101,
        },
        # Measured on one robot, Unitree's Go1 (docs/own-robot.md).
        "robomore.envs.robots.own_robot:OwnRobotEnvironment": {"deterministic_env_fraction": 0.5},
        "robomore.envs.robots.half_cheetah:HalfCheetahEnvironment": {
            "deterministic_env_fraction": 0.5,
        },
        # A stroke pays seconds later.
        "robomore.envs.robots.swimmer:SwimmerEnvironment": {
            "gamma": 0.999,
            "deterministic_env_fraction": 0.5,
        },
    },
}
"""Options by trainer, then by the class that simulates the robot (`Task.environment`)."""

_JOINTS = 8
"""Of the ant whose observations `observed` counts."""


def tuned(trainer: str, task: Task) -> dict[str, Any]:
    """Return the options that this trainer is given for the robot of this task.

    Args:
        trainer: name of an algorithm.
        task: any task, also one of your own. It gets a robot's options if it uses that robot's
            environment class.
    """
    options = dict(_TUNED.get(trainer, {}).get(task.environment, {}))
    # An ant with other joints has its contact forces elsewhere, and sees all.
    if "observed" in options and task.template.count('type="hinge"') != _JOINTS:
        del options["observed"]
    return options


def resolve(trainer: TrainerSettings, task: Task) -> TrainerSettings:
    """Return `trainer` with the tuned options for this task put in; options it has already win.

    A job carries the result, so that tuned options are part of an evaluation's key.
    """
    return TrainerSettings(trainer.name, {**tuned(trainer.name, task), **trainer.options})


def ensure_tuned(trainer: TrainerSettings, task: Task, steps: int | None = None) -> None:
    """Do what `ensure_trainer` does, with the tuned options for this task put in.

    Raises:
        InputError: see `ensure_trainer`. Tuned options that it names are said to be tuned, since
            whoever reads it never gave them.
    """
    try:
        ensure_trainer(resolve(trainer, task), steps)
    except InputError as error:
        named = set(re.findall(r"\w+", str(error)))
        ours = {
            name: value
            for name, value in tuned(trainer.name, task).items()
            if name in named and name not in trainer.options
        }
        if not ours:
            raise
        said = ", ".join(f"{name} = {value:g}" for name, value in ours.items())
        raise InputError(f"{error} ({said} is tuned for {task.id}, not given)") from None
