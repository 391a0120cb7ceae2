"""Where compiled trainers are kept between candidates and runs."""

from __future__ import annotations

import logging
import os
import platform
import shutil
from pathlib import Path
from tempfile import mkdtemp

import msgspec

from robomore.identity import content_key
from robomore.sandbox.call import Containment, run_sandboxed
from robomore.training.compilation import CACHE_VARIABLE, is_damaged, training_code
from robomore.training.settings import versions_for
from robomore.training.warm import Shape
from robomore.types import Limits, Status

_log = logging.getLogger(__name__)


def compiled_trainer(shape: Shape, containment: Containment) -> Path | None:
    """Return the folder of the trainer's compiled code, made now if there is none that is whole.

    Two processes may make the same one side by side; the later one's work is dropped.

    Args:
        shape: what is compiled.
        containment: of the process that compiles.

    Returns:
        A folder to be read and not written to; `None` if there can be none, so that every
        candidate compiles for itself.
    """
    versions = versions_for(shape.trainer)
    folder = cache_folder() / content_key(shape, versions, training_code(), _processor())
    damaged = is_damaged(folder)
    if folder.is_dir() and not damaged:
        return folder
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        partial = Path(mkdtemp(prefix="partial-", dir=folder.parent))
    except OSError:
        return None
    away = partial.with_suffix(".damaged")
    warmed = run_sandboxed(
        "robomore.training.warm:warm",
        msgspec.json.encode(shape),
        partial,
        Limits(),
        environment={CACHE_VARIABLE: str(partial)},
        mode=containment,
    )
    if warmed.status is not Status.OK:
        _log.warning("each training compiles for itself: %s", warmed.diagnosis)
    try:
        if warmed.status is Status.OK:
            if damaged:
                folder.rename(away)
            partial.rename(folder)
    except OSError:
        pass  # Somebody else was first; `folder` is there.
    finally:
        for left in (partial, away):
            shutil.rmtree(left, ignore_errors=True)
    return folder if folder.is_dir() else None


def cache_folder() -> Path:
    """Return the folder of everything that can be made again (`ROBOMORE_CACHE` names another)."""
    if named := os.environ.get(CACHE_VARIABLE):
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "robomore"


def _processor() -> str:
    """Return what tells processors apart: compiled code for one need not run on another."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return f"{platform.machine()} {platform.processor()}"
    return next((line for line in lines if line.startswith(("flags", "Features"))), "")
