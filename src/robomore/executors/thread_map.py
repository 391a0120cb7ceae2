"""Calls that mostly wait (for a server, say), side by side in threads; the answers keep order."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import TypeVar

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Threads:
    """Makes calls side by side.

    Attributes:
        limit: calls under way at once.
    """

    limit: int

    def __call__(self, calls: Sequence[Callable[[], T]], /) -> list[T]:
        """Return what the calls return, in their order, whoever ends first.

        Once a call raises, no further one is begun; those under way may end, so that what they
        paid for is not lost. Then the error is raised, of several that of the earliest call. On
        Ctrl-C nobody waits for them: they end with the process, if not before.
        """
        if self.limit <= 1 or len(calls) <= 1:
            return [call() for call in calls]
        futures: list[Future[T]] = [Future() for _ in calls]
        waiting = iter(range(len(calls)))
        turn, stop = threading.Lock(), threading.Event()

        def work() -> None:
            while True:
                with turn:
                    index = None if stop.is_set() else next(waiting, None)
                if index is None:
                    return
                try:
                    futures[index].set_result(calls[index]())
                except BaseException as error:  # noqa: BLE001  # raised again where it is awaited
                    stop.set()
                    futures[index].set_exception(error)

        # Daemons, unlike a pool's: leaving the program must not wait for a server that is silent.
        threads = [
            threading.Thread(target=work, name=f"call-{number}", daemon=True)
            for number in range(min(self.limit, len(calls)))
        ]
        for thread in threads:
            thread.start()
        try:
            for thread in threads:
                # In short waits, for a Ctrl-C is noticed between them at the latest.
                while thread.is_alive():
                    thread.join(timeout=0.2)
        finally:
            stop.set()
        # Calls are begun in order, so what was never begun stands behind the error that stopped it.
        return [future.result() for future in futures]
