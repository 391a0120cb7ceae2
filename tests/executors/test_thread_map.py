"""Calls in threads: their order, their errors, and how few start after one failed."""

from __future__ import annotations

import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable

import pytest

from robomore.executors import thread_map


def test_results_keep_the_order_of_the_calls() -> None:
    def call(number: int) -> Callable[[], int]:
        return lambda: (time.sleep(0.02 * (5 - number)), number)[1]

    assert thread_map(3)([call(number) for number in range(5)]) == [0, 1, 2, 3, 4]
    assert thread_map(3)([]) == []


@pytest.mark.parametrize("max_workers", [1, 3])
def test_at_most_max_workers_calls_run_at_once(max_workers: int) -> None:
    lock, full, running, most = threading.Lock(), threading.Event(), 0, 0

    def call() -> None:
        nonlocal running, most
        with lock:
            running += 1
            most = max(most, running)
            if running >= max_workers:
                full.set()
        # Whoever comes early waits for the others, so that a slow machine shows as many.
        assert full.wait(10)
        time.sleep(0.02)
        with lock:
            running -= 1

    thread_map(max_workers)([call] * 8)
    assert most == max_workers


def test_the_earliest_error_is_raised_after_the_running_calls_end() -> None:
    second_failed, ended, begun = threading.Event(), [], []

    def first() -> None:
        begun.append(1)
        assert second_failed.wait(10)
        ended.append(1)
        raise ValueError("first")

    def second() -> None:
        begun.append(2)
        second_failed.set()
        raise KeyError("second")

    def third() -> None:
        begun.append(3)

    with pytest.raises(ValueError, match="first"):
        thread_map(2)([first, second, third, third])
    assert ended == [1] and 3 not in begun


def test_ctrl_c_does_not_wait_for_a_call_that_hangs() -> None:
    program = textwrap.dedent(
        """
        import _thread, signal, threading, time
        from robomore.executors import thread_map
        # A shell that starts programs in the background has them ignore it.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        threading.Timer(0.3, _thread.interrupt_main).start()
        try:
            thread_map(2)([lambda: time.sleep(60)] * 2)
        except KeyboardInterrupt:
            print("stopped")
        """
    )
    began = time.monotonic()
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False, timeout=50
    )
    assert done.stdout == "stopped\n", done.stderr
    assert time.monotonic() - began < 30
