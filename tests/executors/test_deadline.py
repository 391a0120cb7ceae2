"""A worker's time limit counts the time in which its parent was running, and no other."""

from __future__ import annotations

import threading
from itertools import count

import pytest

from robomore.executors import worker_process
from robomore.executors.worker_process import _Deadline


class Slept(threading.Event):
    """Waits no time, and counts how often."""

    waits = 0

    def wait(self, timeout: float | None = None) -> bool:
        self.waits += 1
        return self.is_set()


def test_an_hour_in_which_everything_was_stopped_is_one_slice(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hours = count(0, 3600)
    monkeypatch.setattr(worker_process.time, "monotonic", lambda: next(hours))
    ended: list[bool] = []
    deadline = _Deadline(5.0, lambda: ended.append(True))
    deadline._over = slept = Slept()
    deadline.run()
    assert ended == [True] and deadline.passed
    assert slept.waits == 5


def test_a_worker_that_answers_in_time_is_left_alone() -> None:
    ended: list[bool] = []
    deadline = _Deadline(60.0, lambda: ended.append(True))
    deadline.start()
    deadline.cancel()
    deadline.join(5)
    assert not deadline.is_alive() and not ended and not deadline.passed


def test_time_that_is_over_is_over() -> None:
    ended = threading.Event()
    deadline = _Deadline(0.05, ended.set)
    deadline.start()
    assert ended.wait(5)
    deadline.join(5)
    assert deadline.passed
