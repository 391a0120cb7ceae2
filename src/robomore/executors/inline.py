"""Jobs one after the other in this process: for debugging, and for one evaluation at a time."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Generator, Sequence
from functools import partial

from robomore.errors import UnfitWorker
from robomore.executors.executor import Done, Failed, Outcome, Progress, load_function, never


class Inline:
    """Runs jobs in the calling process. It cannot end a job early, so `timeout` has no effect."""

    def __init__(self, workers: int = 1) -> None:
        """Run one job at a time, whatever `workers` says."""
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
        work = load_function(function)
        for index, payload in enumerate(payloads):
            if should_stop():
                return
            progress(index, 0)
            try:
                outcome: Outcome = Done(work(payload, partial(progress, index)))
            except UnfitWorker as error:
                outcome = Failed(str(error), unstarted=True)
            except Exception:  # noqa: BLE001  # the job's error is its outcome
                outcome = Failed(traceback.format_exc())
            yield index, outcome

    def close(self) -> None:
        """There is nothing to stop."""
