"""A video takes as long as what it shows, whatever the file can say of time."""

from __future__ import annotations

import pytest

from robomore.rendering.video import durations


@pytest.mark.parametrize(("tick", "rate"), [(10, 31.25), (1, 31.25), (10, 30.0), (10, 100.0)])
def test_rounding_does_not_add_up(tick: int, rate: float) -> None:
    found = durations(157, rate, tick)
    assert len(found) == 157 and all(one % tick == 0 and one > 0 for one in found)
    assert sum(found) == pytest.approx(157_000 / rate, abs=tick)
