"""Folders that are made once for all workers of a test session, and then only read."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable
from pathlib import Path

import pytest


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], None]) -> Path:
    """Return a folder that the first worker to ask for it has filled.

    Args:
        factory: of the session.
        name: of the folder.
        make: fills it; called with a path that does not exist yet.
    """
    base = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        base = base.parent
    with (base / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        made = base / name
        if not made.exists():
            partial = base / f"{name}.partial"
            make(partial)
            partial.rename(made)
    return made
