"""Turns the text of a trusted reward into a function, in this process.

Only for text that the user chose: the task's own, or one given to `gymnasium.make`. What a designer
wrote is loaded by `robomore.rewards.load`, inside a sandboxed process. This module stands in `envs`
and not in `rewards` because `registration` needs it, and `envs` may not import what stands above.
"""

from __future__ import annotations
import __future__

import linecache
import math
from typing import Any

import numpy as np

from robomore.envs.reward_runner import REWARD_FILENAME
from robomore.envs.robots.base import RewardFunction
from robomore.errors import InvalidReward


def reward_function(source: str) -> RewardFunction:
    """Execute `source` and return its `_get_rew(self, x_velocity, action)`.

    `np`, `numpy` and `math` are there without an import.

    Raises:
        InvalidReward: it does not parse, or defines no such function.
    """
    linecache.cache[REWARD_FILENAME] = (
        len(source),
        None,
        source.splitlines(keepends=True),
        REWARD_FILENAME,
    )
    flags = __future__.annotations.compiler_flag
    try:
        code = compile(source, REWARD_FILENAME, "exec", flags=flags, dont_inherit=True)
    except (SyntaxError, ValueError) as error:
        raise InvalidReward(f"the reward does not parse: {error}") from None
    namespace: dict[str, Any] = {"__name__": "reward", "np": np, "numpy": np, "math": math}
    exec(code, namespace)
    function = namespace.get("_get_rew")
    if not callable(function):
        raise InvalidReward("the reward defines no function `_get_rew(self, x_velocity, action)`")
    loaded: RewardFunction = function
    return loaded
