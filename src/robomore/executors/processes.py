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
from robomore.executors.messages import Call, Progressed, Replied, Reply

_THREAD_PINS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_INHERITED = (
    *("PATH", "HOME", "TMPDIR", "TZ", "LANG", "LC_ALL", "LD_LIBRARY_PATH", "PYTHONPATH"),
    *("XDG_CACHE_HOME", "ROBOMORE_CACHE"),
)
"""What a worker sees of the parent's environment: enough to start Python, and no key."""
_LOG_TAIL = 2000

_Message = tuple[int, int | Outcome] | Exception | None
"""(job's index, units done or outcome); at a slot's end what it failed with, or `None`."""


class Processes:
    """A fixed number of worker processes, kept from batch to batch and replaced when they die."""

    def __init__(self, workers: int) -> None:
        """Prepare `workers` slots; their processes start with their first job."""
        self.workers = workers
        self._slots = [_Slot() for _ in range(workers)]

    def map(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Progress,
        timeout: float,
        should_stop: Callable[[], bool] = never,
    ) -> Generator[tuple[int, Outcome]]:
        """See `Executor.map`. Interrupting the iteration kills all workers."""
        waiting: queue.SimpleQueue[tuple[int, bytes]] = queue.SimpleQueue()
        for job in enumerate(payloads):
            waiting.put(job)
        said: queue.SimpleQueue[_Message] = queue.SimpleQueue()
        threads = [
            threading.Thread(
                target=slot.serve,
                args=(function, waiting, said, timeout, should_stop),
                daemon=True,
            )
            for slot in self._slots[: len(payloads)]
        ]
        for thread in threads:
            thread.start()
        serving = len(threads)
        finished = False
        try:
            while serving:
                message = said.get()
                if message is None:
                    serving -= 1
                elif isinstance(message, Exception):
                    raise message
                else:
                    index, news = message
                    if isinstance(news, int):
                        progress(index, news)
                    else:
                        yield index, news
            finished = True
        finally:
            if not finished:
                self.close()
            for thread in threads:
                thread.join(timeout=10)

    def close(self) -> None:
        """See `Executor.close`."""
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
        waiting: queue.SimpleQueue[tuple[int, bytes]],
        said: queue.SimpleQueue[_Message],
        timeout: float,
        should_stop: Callable[[], bool],
    ) -> None:
        """Take jobs until none waits. Every job taken gets an outcome, whatever happens."""
        failure = None
        try:
            while not self._closed and not should_stop():
                index, payload = waiting.get_nowait()
                said.put((index, 0))
                said.put((index, self._outcome(Call(function, payload), index, said, timeout)))
        except queue.Empty:
            pass  # all jobs have been taken
        except Exception as error:  # noqa: BLE001  # raised again by `map`
            failure = error
        said.put(failure)

    def close(self) -> None:
        """Kill the worker, and with it whatever it started."""
        with self._lock:
            self._closed = True
        self._kill()

    def _outcome(
        self, call: Call, index: int, said: queue.SimpleQueue[_Message], timeout: float
    ) -> Outcome:
        try:
            return self._run(call, index, said, timeout)
        except Exception as error:  # noqa: BLE001  # or it would be waited for for ever
            return Failed(f"the worker process could not be used ({error})", unstarted=True)

    def _run(
        self, call: Call, index: int, said: queue.SimpleQueue[_Message], timeout: float
    ) -> Outcome:
        process = self._started()
        assert process.stdin is not None and process.stdout is not None
        deadline = threading.Timer(timeout, self._kill)
        began = time.monotonic()
        deadline.start()
        try:
            process.stdin.write(msgspec.json.encode(call) + b"\n")
            process.stdin.flush()
            for line in process.stdout:
                reply = msgspec.json.decode(line, type=Reply)
                if isinstance(reply, Progressed):
                    said.put((index, reply.units))
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
            return Failed(f"gave up after {timeout:.0f} s", timed_out=True)
        return Failed(f"the worker process {_how_it_ended(code)}{self._tail()}")

    def _started(self) -> subprocess.Popen[bytes]:
        with self._lock:
            if self._closed:
                raise OSError("the run is being stopped")
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
        return f"; it last said: {text}" if text else ""


def _environment() -> dict[str, str]:
    inherited = {name: os.environ[name] for name in _INHERITED if name in os.environ}
    return inherited | dict.fromkeys(_THREAD_PINS, "1")


def _how_it_ended(code: int) -> str:
    if code < 0:
        name = signal.Signals(-code).name
        hint = " (out of memory, or killed from outside)" if name == "SIGKILL" else ""
        return f"was ended by {name}{hint}"
    return f"exited with status {code}"
