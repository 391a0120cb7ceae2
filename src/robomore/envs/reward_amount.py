"""How much a reward keeps, so that one whose memory grows with every call is noticed."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np

from robomore.envs.reward_objects import ATOMS, address, inside
from robomore.envs.reward_program import RewardInstance

_MOST = 1_000_000


def amount(value: Any, instance: RewardInstance) -> int:
    """Return how many numbers, letters and objects something holds; a bounded deque as if full.

    Args:
        value: that the reward keeps.
        instance: the reward that keeps it.
    """
    seen: set[int] = set()
    total, waiting = 0, [value]
    while waiting and total < _MOST:
        one = waiting.pop()
        total += 1
        if isinstance(one, str | bytes | bytearray):
            total += len(one)
        elif isinstance(one, np.ndarray):
            total += one.size
        elif isinstance(one, deque) and one.maxlen is not None:
            total += one.maxlen
        elif type(one) not in ATOMS and id(one) not in seen and address(one) is None:
            seen.add(id(one))
            waiting += [inner for inner, _ in inside(one, instance)]
    return total
