"""Jobs in worker processes on this machine, one job at a time each."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Generator, Sequence

from robomore.executors.executor import Done, Failed, Outcome, Progress, never
from robomore.executors.worker_process import WorkerProcess

_Message = tuple[int, int | Outcome] | Exception | None
"""From a thread: (index of the job, units done or outcome); at its end its error, or `None`."""
_PATIENCE = 0.2
"""Seconds between two looks whether a thread that waits for a worker is still wanted."""


class Processes:
    """A fixed number of worker processes that are reused, and replaced when they die.

    Several threads may call `map` at once. They share the workers.
    """

    def __init__(self, workers: int) -> None:
        """Prepare `workers` processes. Each starts with its first job."""
        self.workers = workers
        self._idle: queue.LifoQueue[WorkerProcess] = queue.LifoQueue()
        for _ in range(workers):
            self._idle.put(WorkerProcess())
        self._batches: set[_Batch] = set()
        self._closed = False

    def map(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Progress,
        timeout: float,
        should_stop: Callable[[], bool] = never,
    ) -> Generator[tuple[int, Outcome]]:
        """See `Executor.map`. Interrupting the iteration kills the workers of its jobs."""
        if self._closed:
            raise RuntimeError("the executor is closed; make a new one")
        batch = _Batch(self._idle, function, payloads, timeout, should_stop)
        self._batches.add(batch)
        threads = [
            threading.Thread(target=batch.serve, daemon=True)
            for _ in range(min(self.workers, len(payloads)))
        ]
        for thread in threads:
            thread.start()
        serving = len(threads)
        try:
            while serving:
                match batch.messages.get():
                    case None:
                        serving -= 1
                    case Exception() as error:
                        raise error
                    case index, int(units):
                        progress(index, units)
                    case index, (Done() | Failed()) as outcome:
                        yield index, outcome
        finally:
            batch.end()
            self._batches.discard(batch)
            for thread in threads:
                thread.join(timeout=10)

    def close(self) -> None:
        """See `Executor.close`."""
        self._closed = True
        for batch in list(self._batches):
            batch.end()
        try:
            while True:
                self._idle.get_nowait().close()
        except queue.Empty:
            pass


class _Batch:
    """The jobs of one `map`, and the workers that are busy with them."""

    def __init__(
        self,
        idle: queue.LifoQueue[WorkerProcess],
        function: str,
        payloads: Sequence[bytes],
        timeout: float,
        should_stop: Callable[[], bool],
    ) -> None:
        self.messages: queue.SimpleQueue[_Message] = queue.SimpleQueue()
        self._idle = idle
        self._function = function
        self._payloads = payloads
        self._taken = 0
        self._timeout = timeout
        self._should_stop = should_stop
        self._busy: set[WorkerProcess] = set()
        self._ended = False
        self._lock = threading.Lock()

    def serve(self) -> None:
        """Run jobs until none is left. Every job that was taken gets an outcome."""
        failure = None
        try:
            while (worker := self._worker()) is not None:
                try:
                    if not self._serve_next(worker):
                        break
                finally:
                    self._give_back(worker)
        except Exception as error:  # noqa: BLE001  # raised again by `map`
            failure = error
        self.messages.put(failure)

    def end(self) -> None:
        """Start no further job, and kill the workers that are busy with one."""
        with self._lock:
            self._ended = True
            busy = list(self._busy)
        for worker in busy:
            worker.close()

    def _serve_next(self, worker: WorkerProcess) -> bool:
        """Run the next job if there is one and it is wanted."""
        if self._should_stop():
            return False
        with self._lock:
            if self._is_over():
                return False
            index = self._taken
            self._taken += 1
        put = self.messages.put
        put((index, 0))
        payload = self._payloads[index]
        outcome = worker.run(
            self._function, payload, lambda units: put((index, units)), self._timeout
        )
        put((index, outcome))
        return True

    def _is_over(self) -> bool:
        return self._ended or self._taken >= len(self._payloads)

    def _worker(self) -> WorkerProcess | None:
        """Wait for a worker; return `None` once no further job starts."""
        while True:
            try:
                worker = self._idle.get(timeout=_PATIENCE)
            except queue.Empty:
                if self._is_over():
                    return None
                continue
            with self._lock:
                self._busy.add(worker)
            return worker

    def _give_back(self, worker: WorkerProcess) -> None:
        with self._lock:
            self._busy.discard(worker)
        self._idle.put(WorkerProcess() if worker.closed else worker)
