"""What tests of the live page share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from monitor.told import BEGAN
from robomore.events import RunBegan


@pytest.fixture
def began() -> Iterator[RunBegan]:
    """A run that has just begun."""
    yield BEGAN
