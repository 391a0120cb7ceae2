"""A robot, its reward and its policy as a Python package that anybody can install.

The robots of this package are Gymnasium's own classes with another model, and distance and height
are read off a robot at once, so the package of one of the eight tasks needs Gymnasium, MuJoCo and
NumPy alone. Any other class and any other measure of fitness stays where it is: such a package
names RoboMoRe, and a task of an installed package has to be installed too.
"""

from __future__ import annotations

import json
import pprint
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import gymnasium

from robomore.envs.measured_env import SIDE_BY_SIDE
from robomore.errors import ExportFailed
from robomore.export.templates import template
from robomore.identity import derive_seed
from robomore.runs import Run
from robomore.store.manifest import package_versions
from robomore.tasks.portable import is_foreign, task_content
from robomore.tasks.task import Task
from robomore.text import one_line, to_json
from robomore.types import Evaluation

_PLANAR = "robot.data.qpos[1] + robot.model.body_pos[1, 2] - robot.model.qpos0[1]"


@dataclass(frozen=True, slots=True)
class _Official:
    """What an environment of ours is made of: a module and class of Gymnasium's, and changes.

    Attributes:
        module: in `gymnasium.envs.mujoco`.
        name: of the class.
        height: expression for the torso's height in m.
        imports: of what the changes need.
        overrides: lines in the body of the class.
    """

    module: str
    name: str
    height: str = _PLANAR
    imports: str = ""
    overrides: str = ""


_OFFICIAL = {
    "robomore.envs.robots.ant:AntEnvironment": _Official("ant_v5", "AntEnv", "robot.data.qpos[2]"),
    "robomore.envs.robots.hopper:HopperEnvironment": _Official("hopper_v5", "HopperEnv"),
    "robomore.envs.robots.half_cheetah:HalfCheetahEnvironment": _Official(
        "half_cheetah_v5", "HalfCheetahEnv"
    ),
    "robomore.envs.robots.swimmer:SwimmerEnvironment": _Official(
        "swimmer_v5", "SwimmerEnv", "robot.model.body_pos[1, 2]"
    ),
    "robomore.envs.robots.walker:WalkerEnvironment": _Official(
        "walker2d_v5",
        "Walker2dEnv",
        imports="from gymnasium.envs.mujoco.hopper_v5 import HopperEnv\n",
        overrides=(
            "\n    # Healthy as the Hopper is: the state is bounded too.\n"
            "    _healthy_state_range = (-100.0, 100.0)\n"
            "    is_healthy = HopperEnv.is_healthy\n"
        ),
    ),
}

_MEASURED = ("distance", "height")
"""Measures of fitness for which a package needs no RoboMoRe."""


def package_name(task: Task, name: str) -> str:
    """Return what the package of a design is called: `half_cheetah_champion`."""
    plain = re.sub(r"\W+", "_", f"{task.id}_{name}", flags=re.ASCII).strip("_").lower()
    return plain if plain.isidentifier() else f"robot_{plain}"


def environment_id(task: Task, name: str) -> str:
    """Return what `gymnasium.make` is given: `exported/HalfCheetahChampion-v0`."""
    words = package_name(task, name).split("_")
    return f"exported/{''.join(word[:1].upper() + word[1:] for word in words)}-v0"


def stands_alone(task: Task) -> bool:
    """Return whether the package of a task needs no RoboMoRe."""
    return task.environment in _OFFICIAL and task.goal.name in _MEASURED


def environment_package(
    run: Run, evaluation: Evaluation, name: str, mjcf: str, policy: str
) -> dict[str, bytes]:
    """Return the files of the package by their path.

    Args:
        run: that trained the policy.
        evaluation: of it.
        name: of the design in file names.
        mjcf: text of the robot.
        policy: text of the module that acts.

    Raises:
        ExportFailed: the task's options cannot be written down, or its fitness is a function of
            a task file.
    """
    task, package = run.task, package_name(run.task, name)
    alone = stands_alone(task)
    if is_foreign(task.goal):
        raise ExportFailed(
            f"the fitness of {task.id} is a function of its task file, which is not executed from "
            "a run's folder, so that an export could not be checked; a named measure or a task of "
            "a package can be exported"
        )
    parameters = evaluation.design.morphology.parameters
    common = {
        "title": re.sub(r"[^\w ,.:()+-]", " ", one_line(f"{task.title}, {name}")),
        "package": package,
        "distribution": package.replace("_", "-"),
        "id": environment_id(task, name),
        "fitness": task.goal.name,
        "episode_steps": str(task.episode_steps),
        "dependencies": json.dumps(_dependencies(task)),
    }
    inner = {
        "__init__.py": template("init.py", **common),
        "__main__.py": template("main.py", **common),
        "env.py": _environment(task, parameters, common),
        "measure.py": template("measure.py" if alone else "measure_with_robomore.py", **common),
        "policy.py": policy,
        "reward.py": evaluation.design.reward.source,
        "robot.xml": mjcf,
        "recorded.json": to_json(recorded(evaluation) | {"unit": task.goal.unit}).decode() + "\n",
    }
    files = {f"{package}/{file}": text.encode() for file, text in inner.items()}
    if not alone:
        files[f"{package}/task.json"] = task_content(task)
    return files | {"pyproject.toml": template("pyproject.toml", **common).encode()}


def recorded(evaluation: Evaluation) -> dict[str, Any]:
    """Return how a policy was measured: seed and fitness of each episode, and how many at once."""
    episodes = range(len(evaluation.episode_fitness))
    return {
        "rows": min(len(episodes), SIDE_BY_SIDE),
        "seeds": [derive_seed(evaluation.job.seed, "episode", index) for index in episodes],
        "episode_fitness": list(evaluation.episode_fitness),
    }


def _environment(task: Task, parameters: tuple[float, ...], common: Mapping[str, str]) -> str:
    if not stands_alone(task):
        return template(
            "env_with_robomore.py",
            task=task.id,
            task_name=repr(task.id),
            parameters=pprint.pformat(task.named(parameters), sort_dicts=False),
            **{key: common[key] for key in ("title", "episode_steps")},
        )
    official = _OFFICIAL[task.environment]
    options = task.options(task.named(parameters))
    written = pprint.pformat(options, sort_dicts=False)
    if not _is_plain(options):
        raise ExportFailed(f"the options of the task {task.id} are more than numbers: {written}")
    first = f"from gymnasium.envs.mujoco.{official.module} import {official.name}\n"
    return template(
        "env.py",
        imports="".join(sorted((first + official.imports).splitlines(keepends=True))).rstrip(),
        overrides=official.overrides,
        options=written,
        height=official.height,
        **{"class": official.name},
        **{key: common[key] for key in ("title", "fitness", "episode_steps")},
    )


def _is_plain(value: object) -> bool:
    if isinstance(value, dict):
        return all(isinstance(key, str) and _is_plain(item) for key, item in value.items())
    if isinstance(value, tuple | list):
        return all(map(_is_plain, value))
    return value is None or isinstance(value, bool | int | float | str)


def _dependencies(task: Task) -> list[str]:
    versions = package_versions()
    needed = [
        f"gymnasium[mujoco]>={gymnasium.__version__}",
        f"mujoco>={versions['mujoco']},!=4.0.0",
        "numpy>=2",
    ]
    return needed if stands_alone(task) else [f"robomore=={versions['robomore']}", *needed]
