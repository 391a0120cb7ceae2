"""Jobs in worker processes on this machine, one job at a time each."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Generator, Sequence
from typing import IO

import msgspec

from robomore.executors.executor import Done, Failed, Outcome, Progress, never
from robomore.executors.worker import Call, Progressed, Replied, Reply
from robomore.text import to_json

_THREAD_PINS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_INHERITED = (
    *("PATH", "HOME", "TMPDIR", "TZ", "LANG", "LC_ALL", "LD_LIBRARY_PATH", "PYTHONPATH"),
    *("XDG_CACHE_HOME", "ROBOMORE_CACHE"),
)
"""The environment variables that a worker inherits: enough to start Python, and no API key."""
_LOG_TAIL = 2000

_Message = tuple[int, int | Outcome] | Exception | None
"""From a slot: (index of the job, units done or outcome); at its end its error, or `None`."""


class Processes:
    """A fixed number of worker processes that are reused, and replaced when they die."""

    def __init__(self, workers: int) -> None:
        """Prepare `workers` slots. The process of each starts with its first job."""
        self.workers = workers
        self._slots = [_Slot() for _ in range(workers)]
        self._closed = False

    def map(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Progress,
        timeout: float,
        should_stop: Callable[[], bool] = never,
    ) -> Generator[tuple[int, Outcome]]:
        """See `Executor.map`. Interrupting the iteration kills all workers."""
        if self._closed:
            raise RuntimeError("the executor is closed; make a new one")
        jobs: queue.SimpleQueue[tuple[int, bytes]] = queue.SimpleQueue()
        for job in enumerate(payloads):
            jobs.put(job)
        messages: queue.SimpleQueue[_Message] = queue.SimpleQueue()
        threads = [
            threading.Thread(
                target=slot.serve,
                args=(function, jobs, messages, timeout, should_stop),
                daemon=True,
            )
            for slot in self._slots[: len(payloads)]
        ]
        for thread in threads:
            thread.start()
        serving = len(threads)
        try:
            while serving:
                match messages.get():
                    case None:
                        serving -= 1
                    case Exception() as error:
                        raise error
                    case index, int(units):
                        progress(index, units)
                    case index, (Done() | Failed()) as outcome:
                        yield index, outcome
        except BaseException:
            self.close()
            raise
        finally:
            for thread in threads:
                thread.join(timeout=10)

    def close(self) -> None:
        """See `Executor.close`."""
        self._closed = True
        for slot in self._slots:
            slot.close()


class _Slot:
    """One worker process and the thread that talks to it."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._log: IO[bytes] | None = None
        self._closed = False
        self._lock = threading.Lock()

    def serve(
        self,
        function: str,
        jobs: queue.SimpleQueue[tuple[int, bytes]],
        messages: queue.SimpleQueue[_Message],
        timeout: float,
        should_stop: Callable[[], bool],
    ) -> None:
        """Run jobs until none is left. Every job that was taken gets an outcome."""
        failure = None
        try:
            while not self._closed and not should_stop():
                index, payload = jobs.get_nowait()
                messages.put((index, 0))
                try:
                    outcome = self._run(Call(function, payload), index, messages, timeout)
                except Exception as error:  # noqa: BLE001  # `map` waits for an outcome
                    reason = f"the worker process could not be used ({error})"
                    outcome = Failed(reason, unstarted=True)
                messages.put((index, outcome))
        except queue.Empty:
            pass  # all jobs have been taken
        except Exception as error:  # noqa: BLE001  # raised again by `map`
            failure = error
        messages.put(failure)

    def close(self) -> None:
        """Kill the worker and all processes that it started."""
        with self._lock:
            self._closed = True
        self._kill()

    def _run(
        self, call: Call, index: int, messages: queue.SimpleQueue[_Message], timeout: float
    ) -> Outcome:
        process = self._started()
        assert process.stdin is not None and process.stdout is not None
        deadline = threading.Timer(timeout, self._kill)
        began = time.monotonic()
        deadline.start()
        try:
            process.stdin.write(to_json(call) + b"\n")
            process.stdin.flush()
            for line in process.stdout:
                reply = msgspec.json.decode(line, type=Reply)
                if isinstance(reply, Progressed):
                    messages.put((index, reply.units))
                elif isinstance(reply, Replied):
                    return Done(reply.reply)
                else:
                    return Failed(reply.traceback)
        except (BrokenPipeError, msgspec.DecodeError):
            self._kill()
        finally:
            deadline.cancel()
        code = process.wait()
        if time.monotonic() - began >= timeout:
            return Failed(f"not finished after {timeout:.0f} s", timed_out=True)
        return Failed(f"the worker process {_how_it_ended(code)}{self._tail()}")

    def _started(self) -> subprocess.Popen[bytes]:
        with self._lock:
            if self._closed:
                raise OSError("the executor is closed")
            if self._process is None or self._process.poll() is not None:
                self._log = tempfile.TemporaryFile()  # noqa: SIM115  # lives as long as the worker
                self._process = subprocess.Popen(
                    [sys.executable, "-m", "robomore.executors.worker"],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=self._log,
                    # Ctrl-C goes to the parent alone, which then stops the workers in order.
                    start_new_session=True,
                    env=_environment(),
                )
            return self._process

    def _kill(self) -> None:
        process = self._process
        if process is not None and process.poll() is None:
            # The worker leads its own group, so its children go with it.
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                return
            process.wait()

    def _tail(self) -> str:
        if self._log is None:
            return ""
        size = self._log.seek(0, os.SEEK_END)
        self._log.seek(max(0, size - _LOG_TAIL))
        text = self._log.read().decode(errors="replace").strip()
        return f"; its last output: {text}" if text else ""


def _environment() -> dict[str, str]:
    inherited = {name: os.environ[name] for name in _INHERITED if name in os.environ}
    return inherited | dict.fromkeys(_THREAD_PINS, "1")


def _how_it_ended(code: int) -> str:
    if code < 0:
        name = signal.Signals(-code).name
        hint = " (out of memory, or killed from outside)" if name == "SIGKILL" else ""
        return f"was ended by {name}{hint}"
    return f"exited with status {code}"
