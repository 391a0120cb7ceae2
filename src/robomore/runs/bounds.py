"""Where a parameter's value stands between its bounds."""

from __future__ import annotations

import math

from robomore.tasks import Parameter


def share_of_range(parameter: Parameter, value: float) -> float:
    """Return where a value stands, 0 at the lower and 1 at the upper bound, on its own scale."""
    low, high = parameter.low, parameter.high
    if parameter.scale == "log" and low > 0:
        low, high, value = math.log(low), math.log(high), math.log(max(value, low))
    return min(1.0, max(0.0, (value - low) / (high - low)))
