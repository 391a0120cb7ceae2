"""What runs on a machine of a Ray cluster: it hands one job to a worker process beside it.

Ray's own process only passes messages on. The job runs in the same worker process as on a single
machine: its environment is an allow-list, so neither Ray's token nor any key of whoever started
the cluster reaches it.
"""

from __future__ import annotations

import atexit
import os
import queue
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import msgspec

from robomore.errors import RunFolderError
from robomore.executors.carried import carried_folder, packed, unpack
from robomore.executors.executor import Done, Failed, Outcome
from robomore.executors.worker_process import WorkerProcess
from robomore.plain_files import PlainFolder
from robomore.text import to_json

_PREFIX = "robomore-node-"


class Started(msgspec.Struct, tag="started", frozen=True):
    """To the driver: the job has started, and on which node of the cluster."""

    node: str


class Progressed(msgspec.Struct, tag="progress", frozen=True):
    """To the driver: the job has done so many units."""

    units: int


class Ended(msgspec.Struct, tag="ended", frozen=True):
    """To the driver: the outcome. If `left`, the next object is the folder that the job left."""

    reply: bytes | None
    reason: str = ""
    timed_out: bool = False
    unstarted: bool = False
    left: bool = False
    printed: str = ""


Message = Started | Progressed | Ended


def serve(
    function: str,
    payload: bytes,
    timeout: float,
    interval: float,
    folder: str,
    leave: bool,
    content: bytes | None,
) -> Iterator[bytes]:
    """Run one job; yields encoded messages, and at last the folder that it left, if it is wanted.

    Args:
        function: `module:name` of a `JobFunction`.
        payload: of the job.
        timeout: seconds after which it is killed.
        interval: seconds between two reports of progress.
        folder: name of the folder that is carried; empty for none.
        leave: whether that folder is wanted afterwards.
        content: of the folder, `None` if it begins empty.
    """
    here = _Here.get()
    ended = False
    try:
        yield to_json(Started(_node()))
        if content is not None:
            with suppress(ValueError, OSError):  # What cannot be read is done again.
                unpack(content, carried_folder(folder, here.folder))
        messages: queue.SimpleQueue[int | Outcome] = queue.SimpleQueue()

        def work() -> None:
            messages.put(here.worker.run(function, payload, messages.put, timeout))

        threading.Thread(target=work, daemon=True).start()
        told = -interval
        while isinstance(outcome := messages.get(), int):
            if time.monotonic() - told >= interval:
                told = time.monotonic()
                yield to_json(Progressed(outcome))
        ended = True
    finally:
        if not ended:  # It was cancelled, and its worker process is still busy.
            here.close()
    left = None
    if leave and isinstance(outcome, Done):
        with suppress(OSError, RunFolderError):  # Then a later job begins anew.
            left = packed(carried_folder(folder, here.folder))
    here.clean()
    printed = here.worker.printed()
    if isinstance(outcome, Failed):
        yield to_json(
            Ended(None, outcome.reason, outcome.timed_out, outcome.unstarted, printed=printed)
        )
        return
    yield to_json(Ended(outcome.reply, left=left is not None, printed=printed))
    if left is not None:
        yield left


class _Here:
    """The worker process of this Ray process, and its folder on this machine's own disk."""

    _only: _Here | None = None

    def __init__(self) -> None:
        _remove_left_over()
        self.folder = Path(tempfile.mkdtemp(prefix=f"{_PREFIX}{os.getpid()}-"))
        self.worker = WorkerProcess({"TMPDIR": str(self.folder)})
        atexit.register(self.close)

    @classmethod
    def get(cls) -> _Here:
        if cls._only is None or cls._only.worker.closed:
            cls._only = cls()
        return cls._only

    def clean(self) -> None:
        """Remove what the last job left, the scratch folders of killed ones among it."""
        files = PlainFolder(self.folder)
        for name in files.names():
            with suppress(OSError):
                files.remove(name)

    def close(self) -> None:
        self.worker.close()
        _remove(self.folder)


def _remove_left_over() -> None:
    """Remove the folders of processes of ours that were killed."""
    for folder in Path(tempfile.gettempdir()).glob(f"{_PREFIX}*"):
        with suppress(OSError, ValueError):
            owner = int(folder.name.removeprefix(_PREFIX).partition("-")[0])
            if folder.stat().st_uid == os.getuid() and not Path(f"/proc/{owner}").exists():
                _remove(folder)


def _remove(folder: Path) -> None:
    # Untrusted code may have made folders in it, as deep as it liked.
    with suppress(OSError):
        PlainFolder(folder.parent).remove(folder.name)


def _node() -> str:
    import ray

    return str(ray.get_runtime_context().get_node_id())
