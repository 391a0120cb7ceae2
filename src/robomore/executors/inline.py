"""Jobs one after the other in this process: for debugging, and for one evaluation at a time."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from functools import partial

from robomore.executors.executor import Done, Outcome, Progress, load, never


class Inline:
    """Runs jobs here. A job cannot be given up, so `timeout` has no effect."""

    def __init__(self, workers: int = 1) -> None:
        """Take one job at a time, whatever `workers` says."""
        self.workers = 1

    def map(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Progress,
        timeout: float,
        should_stop: Callable[[], bool] = never,
    ) -> Generator[tuple[int, Outcome]]:
        """See `Executor.map`."""
        work = load(function)
        for index, payload in enumerate(payloads):
            if should_stop():
                return
            progress(index, 0)
            yield index, Done(work(payload, partial(progress, index)))

    def close(self) -> None:
        """Nothing to stop."""
