"""When a child has had enough, told by what there is to see of it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from robomore.sandbox.linux.usage import Usage
from robomore.sandbox.watchdog import Snapshot, Verdict, Watchdog
from robomore.types import Limits, Status

LIMITS = Limits(
    wall_seconds=100.0,
    reward_call_seconds=1.0,
    stall_seconds=20.0,
    memory_bytes=1000 * 2**20,
    file_bytes=10 * 2**20,
)
QUIET = Snapshot(
    call=0,
    progress=None,
    printed=0,
    usage=Usage(cpu=0.0, memory=2**20, threads=4),
    left_on_disk=0,
)


def used(**changes: float) -> Usage:
    assert QUIET.usage is not None
    return replace(QUIET.usage, **changes)


def after(seconds: float, *sights: Snapshot, tick: float = 0.5) -> Verdict | None:
    """Return the verdict on a child that shows `sights` in turn, each for `seconds`."""
    dog = Watchdog(LIMITS, cpu_seconds=200.0)
    for sight in sights:
        for _ in range(round(seconds / tick)):
            if (verdict := dog.look(tick, sight)) is not None:
                return verdict
    return None


def test_leaves_a_busy_child_alone() -> None:
    steps = [replace(QUIET, call=n, progress=n, usage=used(cpu=0.9 * n)) for n in range(1, 90)]
    assert after(1.0, *steps) is None


def test_wall_clock() -> None:
    steps = [replace(QUIET, progress=n) for n in range(200)]
    verdict = after(1.0, *steps)
    assert verdict is not None and verdict[0] is Status.TIMED_OUT
    assert "100 s" in verdict[1]


def test_a_sleeping_machine_is_not_charged() -> None:
    dog = Watchdog(LIMITS, cpu_seconds=200.0)
    assert dog.look(100_000.0, QUIET) is None


def test_a_call_that_computes_without_end() -> None:
    inside = [replace(QUIET, call=7, usage=used(cpu=0.4 * n)) for n in range(10)]
    verdict = after(0.5, *inside)
    assert verdict is not None and verdict[0] is Status.TIMED_OUT
    assert "one call of the reward" in verdict[1]


def test_a_call_that_sleeps_gets_longer_and_then_no_more() -> None:
    inside = replace(QUIET, call=7)
    assert after(4.0, inside) is None
    assert after(7.0, inside) is not None


def test_many_calls_are_not_one() -> None:
    steps = [replace(QUIET, call=n + 1, usage=used(cpu=0.5 * n)) for n in range(30)]
    assert after(0.5, *steps) is None


def test_no_progress() -> None:
    verdict = after(25.0, replace(QUIET, progress=3))
    assert verdict == (Status.TIMED_OUT, "made no progress for 20 s")


def test_progress_backwards_is_none() -> None:
    back = [replace(QUIET, progress=-n) for n in range(60)]
    assert after(0.5, *back) is not None


@pytest.mark.parametrize(
    ("sight", "status"),
    [
        (replace(QUIET, usage=used(memory=1001 * 2**20)), Status.OUT_OF_MEMORY),
        (replace(QUIET, usage=used(cpu=201.0)), Status.TIMED_OUT),
        (replace(QUIET, usage=used(threads=10_000)), Status.REWARD_FAILED),
        (replace(QUIET, printed=2**30), Status.REWARD_FAILED),
        (replace(QUIET, left_on_disk=21 * 2**20), Status.REWARD_FAILED),
        (replace(QUIET, left_on_disk=None), Status.REWARD_FAILED),
    ],
)
def test_one_look_is_enough(sight: Snapshot, status: Status) -> None:
    verdict = Watchdog(LIMITS, cpu_seconds=200.0).look(0.1, sight)
    assert verdict is not None and verdict[0] is status


def test_where_nothing_can_be_read_time_still_counts() -> None:
    blind = replace(QUIET, usage=None, call=1)
    assert after(3.0, blind) is not None
