"""The five robots next to their official environments, for comparison step by step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np
from gymnasium.envs.mujoco import MujocoEnv

from robomore.envs.reward_text import reward_function
from robomore.envs.robots import RobotEnvironment, environment_class
from robomore.envs.robots.base import RewardFunction
from robomore.envs.vector_env import VectorEnv
from robomore.tasks import get_task

OFFICIAL = {
    "ant": "Ant-v5",
    "hopper": "Hopper-v5",
    "half-cheetah": "HalfCheetah-v5",
    "swimmer": "Swimmer-v5",
    "walker": "Walker2d-v5",
}


def reference(task: str) -> RewardFunction:
    return reward_function(get_task(task).reward)


def ours(task: str, reward: RewardFunction | None = None, **options: Any) -> RobotEnvironment:
    chosen = get_task(task)
    return environment_class(chosen)(chosen, chosen.reference, reward or reference(task), **options)


def simulations(task: str, n: int = 2, reward: Any = None, **options: Any) -> VectorEnv:
    chosen = get_task(task)
    return VectorEnv(chosen, chosen.reference, n, reward or reference(task), **options)


def official(task: str, folder: Path | None = None) -> gymnasium.Env[Any, Any]:
    """The official environment with the task's limits of health; our body with a `folder`."""
    chosen = get_task(task)
    options = chosen.options(chosen.named(chosen.reference))
    if folder is not None:
        body = folder / f"{task}.xml"
        body.write_text(chosen.mjcf(chosen.reference))
        options["xml_file"] = str(body)
    return gymnasium.make(OFFICIAL[task], **options)


def copy_state(source: Any, target: MujocoEnv) -> None:
    """Put `target` where `source` (an environment) is, warm start included."""
    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.empty(mujoco.mj_stateSize(source.model, kind))
    mujoco.mj_getState(source.model, source.data, state, kind)
    mujoco.mj_setState(target.model, target.data, state, kind)
