"""When a sandboxed process must be ended, judged by snapshots of it."""

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
    disk_bytes=0,
)


def used(**changes: float) -> Usage:
    assert QUIET.usage is not None
    return replace(QUIET.usage, **changes)


def after(seconds: float, *snapshots: Snapshot, interval: float = 0.5) -> Verdict | None:
    """Return the verdict on a process that is as in each snapshot for `seconds`."""
    watchdog = Watchdog(LIMITS, cpu_seconds=200.0)
    for snapshot in snapshots:
        for _ in range(round(seconds / interval)):
            if (verdict := watchdog.check(interval, snapshot)) is not None:
                return verdict
    return None


def test_a_busy_process_is_left_alone() -> None:
    steps = [replace(QUIET, call=n, progress=n, usage=used(cpu=0.9 * n)) for n in range(1, 90)]
    assert after(1.0, *steps) is None


def test_wall_clock() -> None:
    steps = [replace(QUIET, progress=n) for n in range(200)]
    verdict = after(1.0, *steps)
    assert verdict is not None and verdict[0] is Status.TIMED_OUT
    assert "100 s" in verdict[1]


def test_a_sleeping_machine_is_not_charged() -> None:
    watchdog = Watchdog(LIMITS, cpu_seconds=200.0)
    assert watchdog.check(100_000.0, QUIET) is None


def test_a_call_that_computes_without_end() -> None:
    inside = [replace(QUIET, call=7, usage=used(cpu=0.4 * n)) for n in range(10)]
    verdict = after(0.5, *inside)
    assert verdict is not None and verdict[0] is Status.TIMED_OUT
    assert "one call of the reward" in verdict[1]


def test_a_call_that_sleeps_has_a_longer_limit() -> None:
    inside = replace(QUIET, call=7)
    assert after(4.0, inside) is None
    assert after(7.0, inside) is not None


def test_many_calls_are_not_one() -> None:
    steps = [replace(QUIET, call=n + 1, usage=used(cpu=0.5 * n)) for n in range(30)]
    assert after(0.5, *steps) is None


def test_no_progress() -> None:
    verdict = after(25.0, replace(QUIET, progress=3))
    assert verdict == (Status.TIMED_OUT, "made no progress for 20 s")


def test_progress_backwards_is_no_progress() -> None:
    back = [replace(QUIET, progress=-n) for n in range(60)]
    assert after(0.5, *back) is not None


@pytest.mark.parametrize(
    ("snapshot", "status"),
    [
        (replace(QUIET, usage=used(memory=1001 * 2**20)), Status.OUT_OF_MEMORY),
        (replace(QUIET, usage=used(cpu=201.0)), Status.TIMED_OUT),
        (replace(QUIET, usage=used(threads=10_000)), Status.REWARD_FAILED),
        (replace(QUIET, printed=2**30), Status.REWARD_FAILED),
        (replace(QUIET, disk_bytes=21 * 2**20), Status.REWARD_FAILED),
        (replace(QUIET, disk_bytes=None), Status.REWARD_FAILED),
    ],
)
def test_one_snapshot_is_enough(snapshot: Snapshot, status: Status) -> None:
    verdict = Watchdog(LIMITS, cpu_seconds=200.0).check(0.1, snapshot)
    assert verdict is not None and verdict[0] is status


def test_where_usage_cannot_be_read_time_still_counts() -> None:
    unreadable = replace(QUIET, usage=None, call=1)
    assert after(3.0, unreadable) is not None
