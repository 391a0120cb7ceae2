"""Which values of a parametrised test are tried each time, and which by `make test-all` alone."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def more_of(values: Iterable[Any], *always: Any) -> list[Any]:
    """Return `values` for `parametrize`; all but those in `always` are exhaustive."""
    return [
        value if value in always else pytest.param(value, marks=pytest.mark.exhaustive)
        for value in values
    ]
