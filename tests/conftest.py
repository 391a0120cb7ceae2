"""Shared by all tests: no network but loopback, and designs made of nothing."""

from __future__ import annotations

import gc
import socket
from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest

from shared import made_once

_LOOPBACK = {"127.0.0.1", "::1", "localhost"}
_WITHIN = "192.0.2."
"""How the addresses of the test cluster's nodes begin, which exist on this machine alone."""


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Look for garbage among what the tests make alone.

    What is imported and collected lives to the end: millions of objects, and to look through them
    over and over is a third of the collection's time.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


_LONGEST = ("test_run_llm.py", "test_kills.py", "test_hostile.py", "test_whole_runs.py")
"""Files begun first, where each goes to one of several workers: begun last, it would run alone."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the longest files first; all else stays in its order."""
    items.sort(key=lambda item: item.path.name not in _LONGEST)


@pytest.fixture(autouse=True)
def no_network(monkeypatch: pytest.MonkeyPatch) -> None:
    """Refuse connections to anything but this machine."""
    connect = socket.socket.connect

    def guarded(self: socket.socket, address: Any) -> None:
        host = str(address[0]) if isinstance(address, tuple) else ""
        if host and host not in _LOOPBACK and not host.startswith(_WITHIN):
            raise AssertionError(f"a test tried to reach {address}")
        connect(self, address)

    monkeypatch.setattr(socket.socket, "connect", guarded)


@pytest.fixture(scope="session")
def trained_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a whole run that was really trained. Copy it before you write to it."""

    def make(out: Path) -> None:
        from robomore.experiment import run
        from tiny import TINY

        run("swimmer", TINY, seed=1, workers=2, out=out)

    return made_once(tmp_path_factory, "trained_run", make)
