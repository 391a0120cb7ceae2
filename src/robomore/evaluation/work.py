"""What executors call: one encoded request in, one encoded answer out, wherever this runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory, gettempdir

import msgspec

from robomore.errors import InputError, UnfitWorker
from robomore.evaluation.evaluate import evaluate
from robomore.evaluation.request import Request
from robomore.executors.carried import carried_folder
from robomore.sandbox.call import Containment
from robomore.sandbox.layers import ensure
from robomore.text import to_json
from robomore.training.settings import versions_for


def work(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Do an encoded `Request`; returns an encoded `Answer`.

    Raises:
        UnfitWorker: this machine is not as the run needs it; nothing was begun.
    """
    request = msgspec.json.decode(payload, type=Request)
    _refuse_other_versions(request)
    if request.scratch:
        return to_json(evaluate(request, progress))
    _refuse_leaks(request.containment)
    checkpoint = str(carried_folder(request.checkpoint)) if request.checkpoint else ""
    try:
        with TemporaryDirectory(prefix="robomore-", ignore_cleanup_errors=True) as folder:
            here = replace(request, scratch=str(Path(folder) / "scratch"), checkpoint=checkpoint)
            answer = evaluate(here, progress)
            if not answer.evaluation.ok:
                # Before the design is blamed for what may be this machine's fault.
                (Path(folder) / "probe").write_bytes(bytes(_PROBE_BYTES))
    except OSError as error:
        raise UnfitWorker(
            f"this worker cannot write to {gettempdir()} ({error.strerror}); free disk space "
            "there, or set TMPDIR to another folder"
        ) from None
    return to_json(answer)


_PROBE_BYTES = 4 * 2**20
"""More than a training leaves."""


def _refuse_other_versions(request: Request) -> None:
    """Refuse to give numbers that would be others than those that the run began with.

    Raises:
        UnfitWorker: naming the packages, or the trainer.
    """
    try:
        found = versions_for(request.job.trainer)
    except InputError as error:
        raise UnfitWorker(str(error)) from None
    other = [
        f"{name} {found.get(name, 'absent')} instead of {version}"
        for name, version in request.versions.items()
        if found.get(name) != version
    ]
    if other:
        raise UnfitWorker(
            f"this worker has {', '.join(other)}, which could change the numbers: it was edited or "
            "installed anew since the run began, or differs from machine to machine; give every "
            "worker the same as the run"
        )


@cache
def _refuse_leaks(containment: str) -> None:
    """Check once in this process that the sandbox of this machine holds.

    Raises:
        UnfitWorker: a layer is missing, and `containment` is strict.
    """
    try:
        ensure(Containment(containment))
    except InputError as error:
        raise UnfitWorker(str(error)) from None
