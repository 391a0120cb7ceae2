"""A Ray cluster of several nodes on this machine, and what must not be left of it."""

from __future__ import annotations

import os
import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from robomore.executors.ray_cluster import read_token_again


@contextmanager
def ray_cluster(nodes: int) -> Iterator[Any]:
    """Start a head that takes no jobs and so many nodes of one core; gives Ray's `Cluster`."""
    os.environ["RAY_AUTH_MODE"] = "token"
    os.environ["RAY_AUTH_TOKEN"] = secrets.token_hex(32)
    # Ray's processes would give way to everything else that this machine does.
    os.environ["RAY_worker_niceness"] = "0"  # noqa: SIM112  # its name
    from ray.cluster_utils import Cluster

    read_token_again()

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0})
    try:
        for _ in range(nodes):
            cluster.add_node(num_cpus=1)
        yield cluster
    finally:
        cluster.shutdown()
        for name in ("RAY_AUTH_MODE", "RAY_AUTH_TOKEN", "RAY_worker_niceness"):
            os.environ.pop(name, None)


def ray_processes() -> list[int]:
    """Return the Ray processes that come from this one."""
    return [
        process
        for process in descendants(os.getpid())
        if b"ray::" in (line := _command_line(process)) or b"/ray/" in line
    ]


def descendants(ancestor: int) -> list[int]:
    """Return a process and all that come from it."""
    parents = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            line = (folder / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if line[0] != "Z":
            parents[int(folder.name)] = int(line[1])

    def comes(process: int) -> bool:
        return process == ancestor or (process in parents and comes(parents[process]))

    return [process for process in parents if comes(process)]


def kill_at_work(cluster: Any, node: Any, seconds: float = 300.0) -> None:
    """Kill a node of one core as soon as it is busy with a job."""
    raylet = node.all_processes["raylet"][0].process.pid
    deadline = time.monotonic() + seconds
    while not any(b"ray::serve" in _command_line(one) for one in descendants(raylet)):
        assert time.monotonic() < deadline, "it is never busy"
        time.sleep(0.05)
    cluster.remove_node(node, allow_graceful=False)


def _command_line(process: int) -> bytes:
    with suppress(OSError):
        return Path(f"/proc/{process}/cmdline").read_bytes()
    return b""


def command(process: int) -> bytes:
    """Return the program of a process."""
    return Path(f"/proc/{process}/cmdline").read_bytes().partition(b"\0")[0]


def until_none_is_left(seconds: float = 30.0) -> list[int]:
    """Wait until there is no Ray process of ours; return those that stay."""
    deadline = time.monotonic() + seconds
    while (left := ray_processes()) and time.monotonic() < deadline:
        time.sleep(0.1)
    return left


def memory_holds(process: int, text: bytes) -> bool:
    """Return whether a process has a text in its own memory (not that of the object store)."""
    try:
        maps = Path(f"/proc/{process}/maps").read_text().splitlines()
        with Path(f"/proc/{process}/mem").open("rb") as memory:
            for line in maps:
                area, mode, *rest = line.split()
                begin, end = (int(one, 16) for one in area.split("-"))
                if mode.startswith("rw") and end - begin < 2**28 and "/dev/shm" not in rest[-1]:
                    memory.seek(begin)
                    with suppress(OSError):
                        if text in memory.read(end - begin):
                            return True
    except OSError:
        return False
    return False
