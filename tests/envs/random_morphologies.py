"""Random bodies that a task accepts."""

from __future__ import annotations

import math

import numpy as np

from robomore.tasks import Parameter, Task

TRIES = 20_000


def random_body(task: Task, seed: int) -> tuple[float, ...]:
    """Return parameters spread over the search ranges (often at their ends) that pass all rules."""
    task = task.searched()
    random = np.random.default_rng(seed)
    for _ in range(TRIES):
        shares = random.random(len(task.parameters))
        extreme = random.random(len(shares)) < 0.15
        shares = np.where(extreme, np.round(shares), shares)
        body = [
            at(parameter, share) for parameter, share in zip(task.parameters, shares, strict=True)
        ]
        values = dict(zip(task.names, body, strict=True))
        if not any(rule.violation(values) for rule in task.rules):
            return task.check(body)
    raise AssertionError(f"no valid body of {task.id} in {TRIES} tries")


def at(parameter: Parameter, share: float) -> float:
    """Return the value at `share` of a parameter's range, in its own scale."""
    low, high = parameter.low, parameter.high
    if parameter.scale == "log" and low > 0:
        value = math.exp(math.log(low) + share * math.log(high / low))
    else:
        value = low + share * (high - low)
    return min(max(value, low), high)
