"""One worker process, seen from its parent: it runs one job at a time, and is replaced if it dies.

It gets an allow-list of the parent's environment, so no API key reaches it.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from typing import IO

import msgspec

from robomore.executors.executor import Done, Failed, Outcome
from robomore.executors.worker import Call, Progressed, Replied, Reply, Unfit
from robomore.processes import clean_environment, signal_name
from robomore.text import to_json

_THREAD_PINS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_LOG_TAIL = 2000
_SLICE_SECONDS = 1.0
"""Of a worker's time limit that are counted at once."""


class WorkerProcess:
    """A process that starts with its first job.

    Args:
        extra: environment variables besides those of the allow-list. Never pass a secret.
    """

    def __init__(self, extra: Mapping[str, str] = {}) -> None:
        self._extra = dict(extra)
        self._process: subprocess.Popen[bytes] | None = None
        self._log: IO[bytes] | None = None
        self._told = 0
        self._lock = threading.Lock()
        self.closed = False

    def run(
        self, function: str, payload: bytes, progress: Callable[[int], None], timeout: float
    ) -> Outcome:
        """Run one job and return how it ended.

        Args:
            function: `module:name` of a `JobFunction`.
            payload: of the job.
            progress: told the units done, in this thread.
            timeout: seconds after which the process is killed.
        """
        try:
            process = self._started()
        except Exception as error:  # noqa: BLE001  # whatever it is, no design is to blame
            reason = f"the worker process could not be used ({type(error).__name__}: {error})"
            return Failed(reason, unstarted=True)
        assert process.stdin is not None and process.stdout is not None
        deadline = _Deadline(timeout, self._kill)
        deadline.start()
        try:
            process.stdin.write(to_json(Call(function, payload)) + b"\n")
            process.stdin.flush()
            for line in process.stdout:
                reply = msgspec.json.decode(line, type=Reply)
                if isinstance(reply, Progressed):
                    progress(reply.units)
                elif isinstance(reply, Replied):
                    return Done(reply.reply)
                elif isinstance(reply, Unfit):
                    return Failed(reply.reason, unstarted=True)
                else:
                    return Failed(reply.traceback)
        except (BrokenPipeError, msgspec.DecodeError):
            self._kill()
        finally:
            deadline.cancel()
        code = process.wait()
        if deadline.passed:
            return Failed(f"not finished after {timeout:.0f} s", timed_out=True)
        tail = self.printed()
        said = f"; its last output: {tail}" if tail else ""
        return Failed(f"the worker process {_how_it_ended(code)}{said}")

    def printed(self) -> str:
        """Return the end of what the process printed since the last call."""
        if self._log is None:
            return ""
        size = self._log.seek(0, os.SEEK_END)
        self._log.seek(max(self._told, size - _LOG_TAIL))
        self._told = size
        return self._log.read().decode(errors="replace").strip()

    def close(self) -> None:
        """Kill the process and all processes that it started. There will be no other."""
        with self._lock:
            self.closed = True
        self._kill()

    def _started(self) -> subprocess.Popen[bytes]:
        with self._lock:
            if self.closed:
                raise OSError("the executor is closed")
            if self._process is None or self._process.poll() is not None:
                self._log = tempfile.TemporaryFile()  # noqa: SIM115  # lives as long as the worker
                self._told = 0
                self._process = subprocess.Popen(
                    [sys.executable, "-m", "robomore.executors.worker"],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=self._log,
                    # Ctrl-C goes to the parent alone, which then stops the workers in order.
                    start_new_session=True,
                    env=clean_environment() | dict.fromkeys(_THREAD_PINS, "1") | self._extra,
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


class _Deadline(threading.Thread):
    """Calls `end` after so many seconds in which this process was running.

    Time in which it was stopped, or the machine slept, is charged one slice at most: the worker's
    answer may be waiting.
    """

    def __init__(self, seconds: float, end: Callable[[], None]) -> None:
        super().__init__(daemon=True)
        self._left, self._end = seconds, end
        self._over = threading.Event()
        self.passed = False

    def run(self) -> None:
        while self._left > 0:
            began, slice_ = time.monotonic(), min(_SLICE_SECONDS, self._left)
            if self._over.wait(slice_):
                return
            self._left -= min(time.monotonic() - began, slice_)
        self.passed = True
        self._end()

    def cancel(self) -> None:
        """Do nothing any more."""
        self._over.set()


def _how_it_ended(code: int) -> str:
    if code < 0:
        name = signal_name(-code)
        hint = " (out of memory, or killed from outside)" if name == "SIGKILL" else ""
        return f"was ended by {name}{hint}"
    return f"exited with status {code}"
