"""A child process that never stays behind: it is killed with its group, and it is reaped."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO


class ChildProcess:
    """A process in a session of its own, with standard input and one pipe for all that it prints.

    Attributes:
        pid: its process id, which is also the id of its process group.
        stdin: what it reads.
        printed: what it and its group print, errors included.
        exit_code: as in `subprocess`, negative for a signal; `None` until it is reaped.
        cpu_seconds: processor time it used, known once it is reaped.
    """

    def __init__(
        self,
        command: Sequence[str],
        folder: Path,
        environment: Mapping[str, str],
        descriptors: Sequence[int],
    ) -> None:
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            bufsize=0,
            cwd=folder,
            env=environment,
            pass_fds=descriptors,
            start_new_session=True,
        )
        assert self._process.stdin is not None and self._process.stdout is not None
        self.pid = self._process.pid
        self.stdin: IO[bytes] = self._process.stdin
        self.printed: IO[bytes] = self._process.stdout
        self.exit_code: int | None = None
        self.cpu_seconds = 0.0

    def ended(self) -> bool:
        """Say whether it has ended; if so, kill what is left of its group and reap it."""
        if self.exit_code is None and self._zombie():
            self._reap()
        return self.exit_code is not None

    def ends_within(self, seconds: float) -> bool:
        """Wait up to `seconds` for its end; say whether it has ended."""
        deadline = time.monotonic() + seconds
        while not self.ended():
            if time.monotonic() >= deadline:
                return False
            time.sleep(0.002)
        return True

    def ask_for_traceback(self) -> None:
        """Have it print which line it is in (see `child`)."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.pid, signal.SIGUSR1)

    def close(self) -> None:
        """Kill it and its group if need be, reap it and close its pipes."""
        if self.exit_code is None:
            self._reap()
        for stream in (self.stdin, self.printed):
            with contextlib.suppress(OSError):
                stream.close()

    def _zombie(self) -> bool:
        # The leader stays a zombie until `_reap`, so that its group's number cannot be reused
        # before the group is killed.
        return os.waitid(os.P_PID, self.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None

    def _reap(self) -> None:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self.pid, signal.SIGKILL)
        _, status, costs = os.wait4(self.pid, 0)
        self.exit_code = self._process.returncode = os.waitstatus_to_exitcode(status)
        self.cpu_seconds = costs.ru_utime + costs.ru_stime
