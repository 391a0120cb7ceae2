"""Strangers let loose: none may get anything across the boundary, whatever becomes of them."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec
import pytest
from attempts import Attempt, attempts
from miniature import BEST, Claims, measure
from world import World, encode, world

from robomore.sandbox.check import check_reward
from robomore.sandbox.contain import Contained, run_contained
from robomore.sandbox.layers import strict_is_possible
from robomore.types import Limits, Status

pytestmark = pytest.mark.skipif(
    not strict_is_possible(), reason="this machine cannot contain a stranger"
)

LIMITS = Limits(
    wall_seconds=12.0,
    reward_call_seconds=0.4,
    stall_seconds=2.5,
    memory_bytes=400 * 2**20,
    file_bytes=8 * 2**20,
)

HONEST = (
    "def _get_rew(self, x_velocity, action):\n    return float(x_velocity), {'speed': x_velocity}\n"
)


@pytest.fixture(scope="module")
def planted() -> Iterator[World]:
    with world() as made:
        yield made


@pytest.mark.parametrize("attempt", attempts(), ids=lambda attempt: attempt.name)
def test_nothing_gets_across(
    attempt: Attempt, planted: World, record_property: pytest.RecordProperty
) -> None:
    source = planted.address(attempt.source)
    severities = {finding.severity for finding in check_reward(source)}
    checked = next((it for it in ("error", "warning") if it in severities), "clean")
    scratch = planted.scratch(attempt.name)
    contained = run_contained(
        "miniature:train",
        encode(source),
        scratch,
        LIMITS,
        readable=[planted.root / "readable"],
    )
    breaches = planted.breaches(contained, scratch)
    record_property("attempt", attempt.words)
    record_property("check", checked)
    record_property("outcome", contained.status.value)
    record_property("breaches", "; ".join(breaches) or "none")

    assert not breaches
    assert contained.status in attempt.expected, contained.diagnosis + contained.log
    assert checked in attempt.check
    assert (contained.diagnosis == "") == (contained.status is Status.OK)
    assert len(contained.diagnosis) < 50_000
    if contained.status is Status.OK:
        assert _fitness(contained, planted, attempt) <= BEST


def _fitness(contained: Contained, planted: World, attempt: Attempt) -> float:
    """Return what the parent measures, minus infinity where it refuses what was left behind."""
    try:
        msgspec.json.decode(contained.reply, type=Claims)
        return measure(planted.root / "scratch" / attempt.name.replace("/", "-"))
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return float("-inf")
