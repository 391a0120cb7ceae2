"""Turns the text of a reward into a function. Only call this inside a sandboxed process: the text
is executed, and nothing but the operating system's boundary protects against it.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING

from robomore.envs.reward_program import NAME, RewardProgram
from robomore.errors import InvalidReward
from robomore.sandbox import heartbeat
from robomore.sandbox.explain import explain

if TYPE_CHECKING:
    from robomore.envs.robots.base import RewardFunction


def load_reward(
    source: str, watch: Callable[[RewardFunction], RewardFunction] | None = None
) -> RewardProgram:
    """Execute `source` and return its `_get_rew(self, x_velocity, action)`.

    `np`, `numpy` and `math` are there without an import, annotations are not evaluated, and `print`
    does nothing. While a parent watches, each call is counted for it (see `heartbeat`).

    Args:
        source: program text of the reward.
        watch: given each simulation's function; returns what is called in its place.

    Raises:
        InvalidReward: with line and reason, where the text does not compile, fails as it is
            executed, or defines no `_get_rew` that takes (self, x_velocity, action).
    """

    def counted(function: RewardFunction) -> RewardFunction:
        function = heartbeat.watch(function)
        return watch(function) if watch else function

    program = RewardProgram(source, {"print": _silent}, heartbeat.watched, counted)
    try:
        function = program.instance().namespace[NAME]
    except InvalidReward:
        raise
    except BaseException as error:  # noqa: BLE001  # untrusted code may raise SystemExit and worse
        raise InvalidReward(f"fails before any call: {explain(error)}") from None
    try:
        with heartbeat.watched():
            inspect.signature(function).bind(None, 0.0, None)
    except BaseException as error:  # noqa: BLE001  # it may run untrusted code
        raise InvalidReward(
            f"`_get_rew` does not take (self, x_velocity, action): {explain(error)}"
        ) from None
    return program


def _silent(*values: object, **options: object) -> None:
    """Stands in for `print`: half a million lines a candidate help nobody."""
