"""A Ray cluster of several nodes on this machine, and what must not be left of it."""

from __future__ import annotations

import os
import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


@contextmanager
def ray_cluster(nodes: int) -> Iterator[Any]:
    """Start a head that takes no jobs and so many nodes of one core; gives Ray's `Cluster`."""
    os.environ["RAY_AUTH_MODE"] = "token"
    os.environ["RAY_AUTH_TOKEN"] = secrets.token_hex(32)
    # Ray's processes would give way to everything else that this machine does.
    os.environ["RAY_worker_niceness"] = "0"  # noqa: SIM112  # its name
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0})
    try:
        for _ in range(nodes):
            cluster.add_node(num_cpus=1)
        yield cluster
    finally:
        cluster.shutdown()
        for name in ("RAY_AUTH_MODE", "RAY_AUTH_TOKEN", "RAY_worker_niceness"):
            os.environ.pop(name, None)


def ray_processes() -> list[str]:
    """Return the Ray processes that come from this one."""
    found = []
    for status in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            command = status.read_bytes().replace(b"\0", b" ").decode(errors="replace")
            line = int((status.parent / "stat").read_text().rpartition(")")[2].split()[1])
        except (OSError, ValueError):
            continue
        if line == os.getpid() and ("ray::" in command or "/ray/core/src/ray/" in command):
            found.append(command)
    return found


def until_none_is_left(seconds: float = 30.0) -> list[str]:
    """Wait until there is no Ray process of ours; return those that stay."""
    deadline = time.monotonic() + seconds
    while (left := ray_processes()) and time.monotonic() < deadline:
        time.sleep(0.1)
    return left
