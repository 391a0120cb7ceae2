"""Where a parameter's value stands between its bounds."""

from __future__ import annotations

import math
from collections.abc import Sequence

from robomore.tasks import Parameter, Task

_AT_BOUND = 0.01
"""A parameter counts as at its bound within this share of its range."""


def at_bounds(task: Task, parameters: Sequence[float]) -> list[str]:
    """Return the names of the parameters that stand at a bound, in the task's order."""
    found = []
    for parameter, value in zip(task.parameters, parameters, strict=True):
        near = _AT_BOUND * (parameter.high - parameter.low)
        if parameter.scale == "log":
            near = _AT_BOUND * value
        if min(abs(value - parameter.low), abs(value - parameter.high)) <= near:
            found.append(parameter.name)
    return found


def share_of_range(parameter: Parameter, value: float) -> float:
    """Return where a value stands, 0 at the lower and 1 at the upper bound, on its own scale."""
    low, high = parameter.low, parameter.high
    if parameter.scale == "log" and low > 0:
        low, high, value = math.log(low), math.log(high), math.log(max(value, low))
    return min(1.0, max(0.0, (value - low) / (high - low)))
