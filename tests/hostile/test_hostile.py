"""Hostile programs in the sandbox: none may get anything across its boundary."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec
import pytest
from attempts import Attempt, parameters
from miniature import BEST, Claims, measure
from world import World, encode, world

from robomore.rewards.check import check_reward
from robomore.sandbox.call import SandboxResult, run_sandboxed
from robomore.types import Limits, Status
from strict import strictly

pytestmark = strictly

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


@pytest.mark.parametrize("attempt", parameters())
def test_nothing_gets_across(
    attempt: Attempt, planted: World, record_property: pytest.RecordProperty
) -> None:
    source = planted.address(attempt.source)
    severities = {finding.severity for finding in check_reward(source)}
    checked = next((it for it in ("error", "warning") if it in severities), "clean")
    scratch = planted.scratch(attempt.name)
    result = run_sandboxed(
        "miniature:train",
        encode(source),
        scratch,
        LIMITS,
        readable=[planted.root / "readable"],
    )
    breaches = planted.breaches(result, scratch)
    record_property("attempt", attempt.words)
    record_property("check", checked)
    record_property("outcome", result.status.value)
    record_property("breaches", "; ".join(breaches) or "none")

    assert not breaches
    assert result.status in attempt.expected, result.diagnosis + result.log
    assert checked in attempt.check
    assert (result.diagnosis == "") == (result.status is Status.OK)
    assert len(result.diagnosis) < 50_000
    if result.status is Status.OK:
        assert _fitness(result, planted, attempt) <= BEST


def _fitness(result: SandboxResult, planted: World, attempt: Attempt) -> float:
    """Return what the parent measures, minus infinity where it refuses what was left behind."""
    try:
        msgspec.json.decode(result.reply, type=Claims)
        return measure(planted.root / "scratch" / attempt.name.replace("/", "-"))
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return float("-inf")
