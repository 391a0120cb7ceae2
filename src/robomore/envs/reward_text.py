"""Turns the text of a trusted reward into a function, in this process.

Only for text that the user chose: the task's own, or one given to `gymnasium.make`. What a designer
wrote is loaded by `robomore.rewards.load`, inside a sandboxed process. This module stands in `envs`
and not in `rewards` because `registration` needs it, and `envs` may not import what stands above.
"""

from __future__ import annotations

from robomore.envs.reward_program import RewardProgram


def reward_function(source: str) -> RewardProgram:
    """Execute `source` and return its `_get_rew(self, x_velocity, action)`.

    `np`, `numpy` and `math` are there without an import.

    Raises:
        InvalidReward: it does not parse, or defines no such function.
    """
    program = RewardProgram(source)
    program.instance()
    return program
