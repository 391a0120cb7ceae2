"""What a process uses is seen whichever of its threads are left."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from robomore.plain_files import PlainFolder
from robomore.sandbox.linux import usage as module
from robomore.sandbox.linux.usage import folder_bytes, usage

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


def test_threads_that_end_as_they_are_looked_at_hide_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[str] = []

    def status(task: Path) -> dict[bytes, int]:
        seen.append(task.name)
        if len(seen) == 2:
            raise ProcessLookupError
        return {b"VmRSS": 7} if len(seen) > 2 else {}

    monkeypatch.setattr(module, "_status", status)
    monkeypatch.setattr(Path, "iterdir", lambda path: iter([Path("2"), Path("3")]))
    used = usage(os.getpid())
    assert used is not None and used.memory == 7 and seen[1:] == ["2", "3"]


def test_space_that_cannot_be_counted_is_not_overlooked(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "b").write_bytes(bytes(8192))
    assert folder_bytes(tmp_path, 10) == 8192
    assert folder_bytes(tmp_path, 1) is None
    assert folder_bytes(tmp_path / "none", 10) == 0
    descriptor = os.open(tmp_path / "a", os.O_RDONLY)
    for _ in range(25):
        os.mkdir("d" * 200, dir_fd=descriptor)
        inner = os.open("d" * 200, os.O_RDONLY, dir_fd=descriptor)
        os.close(descriptor)
        descriptor = inner
    os.close(descriptor)
    assert folder_bytes(tmp_path, 100) is None
    PlainFolder(tmp_path).remove("a")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may enter every folder")
def test_a_folder_that_its_owner_closed_is_not_overlooked(tmp_path: Path) -> None:
    (tmp_path / "closed").mkdir(mode=0o300)
    assert folder_bytes(tmp_path, 10) is None
