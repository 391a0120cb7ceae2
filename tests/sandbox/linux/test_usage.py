"""What a process uses is seen whichever of its threads are left."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

from robomore.sandbox.linux.usage import usage

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="only Linux has /proc")

MAIN_THREAD_ENDS = """
import ctypes, platform, sys, threading, time
def take():
    kept = bytearray(80_000_000)
    print("taken", flush=True)
    time.sleep(60)
threading.Thread(target=take).start()
time.sleep(0.2)
ctypes.CDLL(None).syscall(60 if platform.machine() == "x86_64" else 93, 0)
"""


def test_memory_is_seen_when_the_first_thread_has_ended() -> None:
    with subprocess.Popen([sys.executable, "-c", MAIN_THREAD_ENDS], stdout=subprocess.PIPE) as it:
        try:
            assert it.stdout is not None and it.stdout.readline() == b"taken\n"
            deadline = time.monotonic() + 10
            while b"VmRSS" in Path(f"/proc/{it.pid}/status").read_bytes():
                assert time.monotonic() < deadline
                time.sleep(0.02)
            used = usage(it.pid)
            assert used is not None and used.memory > 80_000_000
            assert used.peak_memory >= 80_000_000
        finally:
            it.kill()


def test_a_process_that_is_gone_is_not_there() -> None:
    done = subprocess.Popen([sys.executable, "-c", ""])
    done.wait()
    assert usage(done.pid) is None
