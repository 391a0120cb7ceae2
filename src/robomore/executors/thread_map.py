"""Runs calls that mostly wait (for a server, say) in threads, and keeps the order of results."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Protocol, TypeVar

T = TypeVar("T")


class _Map(Protocol):
    def __call__(self, calls: Sequence[Callable[[], T]], /) -> list[T]: ...


def thread_map(max_workers: int) -> _Map:
    """Return a function that runs a list of calls in at most `max_workers` threads.

    The function returns the results in the order of the calls. When a call raises, no further call
    starts. Calls that already run may finish, so that what they paid for is kept. Then the error is
    raised; if there are several, it is the error of the earliest call. Ctrl-C does not wait for the
    running calls.
    """

    def run(calls: Sequence[Callable[[], T]], /) -> list[T]:
        if max_workers <= 1 or len(calls) <= 1:
            return [call() for call in calls]
        futures: list[Future[T]] = [Future() for _ in calls]
        waiting = iter(range(len(calls)))
        lock, stop = threading.Lock(), threading.Event()

        def work() -> None:
            while True:
                with lock:
                    index = None if stop.is_set() else next(waiting, None)
                if index is None:
                    return
                try:
                    futures[index].set_result(calls[index]())
                except BaseException as error:  # noqa: BLE001  # it is raised again below
                    stop.set()
                    futures[index].set_exception(error)

        # The threads are daemons: a server that never answers must not keep the program alive.
        threads = [
            threading.Thread(target=work, name=f"call-{number}", daemon=True)
            for number in range(min(max_workers, len(calls)))
        ]
        for thread in threads:
            thread.start()
        try:
            for thread in threads:
                # Python handles Ctrl-C only between two waits, so each wait is short.
                while thread.is_alive():
                    thread.join(timeout=0.2)
        finally:
            stop.set()
        # Calls start in order. So a call that never started comes after the one that failed.
        return [future.result() for future in futures]

    return run
