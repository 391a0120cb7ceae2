"""Checkpoints: a folder with JSON files and the arrays that they name, no code in either.

Each checkpoint has a number and files of its own, the JSON file written last. It carries digests of
the arrays and of itself, so a reader takes the latest that is whole, whenever the writer dies.
Nothing is renamed or removed for that, which a sandboxed process may not do.
"""

from __future__ import annotations

import hashlib
import json
import logging
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from robomore.plain_files import PlainFolder

log = logging.getLogger(__name__)

VERSION = 4
_NAME = re.compile(r"(checkpoint|arrays|environment)-(\d{1,9})\.(json|npz)")
_PARTS = ("arrays", "environment")


@dataclass(frozen=True)
class Checkpoint:
    """What is needed to continue.

    Attributes:
        facts: JSON values.
        arrays: of the trainer, by name.
        environment: what `TrainingEnv.state` returned.
    """

    facts: dict[str, Any]
    arrays: dict[str, NDArray[Any]]
    environment: dict[str, NDArray[Any]]


def save_checkpoint(folder: Path, checkpoint: Checkpoint) -> None:
    """Write `checkpoint` into `folder`, in the place of what it held."""
    folder.mkdir(parents=True, exist_ok=True)
    number = next((number + 1 for number in _numbers(folder) if _index(folder, number)), 0)
    digests = {}
    for part in _PARTS:
        plain: dict[str, Any] = {k: np.asarray(v) for k, v in getattr(checkpoint, part).items()}
        path = folder / f"{part}-{number}.npz"
        np.savez(path, allow_pickle=False, **plain)
        digests[part] = _file_digest(path)
    index = {"version": VERSION, "number": number, "facts": checkpoint.facts, "digests": digests}
    text = json.dumps(index | {"digest": _digest(index)})
    _index_path(folder, number).write_text(text, encoding="utf-8")
    with suppress(PermissionError):  # of a sandboxed process; whoever started it does it then
        drop_older(folder)


def load_checkpoint(folder: Path) -> Checkpoint | None:
    """Return what `folder` holds, `None` where there is nothing or nothing that can be read."""
    for number in _numbers(folder):
        index = _index(folder, number)
        if index is None:
            continue
        try:
            parts = []
            for part in _PARTS:
                path = folder / f"{part}-{number}.npz"
                if _file_digest(path) != index["digests"][part]:
                    raise ValueError(f"{path.name} does not match its digest")
                with np.load(path, allow_pickle=False) as stored:
                    parts.append({name: stored[name] for name in stored.files})
            return Checkpoint(index["facts"], *parts)
        except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
            _warn(folder, error)
    return None


def drop_older(folder: Path) -> None:
    """Remove all that does not belong to the latest checkpoint in `folder`, if there is one.

    Nothing is read, so that it does no harm whoever wrote the files. So the latest has to be whole:
    this is for after a writer that has ended well.
    """
    files = PlainFolder(folder)
    numbers = _numbers(folder)
    for name in files.names() if numbers else ():
        match = _NAME.fullmatch(name)
        if match is None or int(match[2]) != numbers[0]:
            files.remove(name)


def checkpoint_of(folder: Path, identity: Any, most_steps: int) -> Checkpoint | None:
    """Return what `folder` holds if a training may continue from it.

    Args:
        folder: may hold a checkpoint whose facts have `identity` and `steps`.
        identity: of the training, as JSON values; a checkpoint is of this training if it is equal.
        most_steps: control steps that the training may have done.
    """
    found = load_checkpoint(folder)
    if found is None:
        return None
    if found.facts["identity"] != identity:
        log.warning("the checkpoint in %s is of another training; starting anew", folder)
        return None
    if found.facts["steps"] > most_steps:
        log.info("the checkpoint in %s is past %d steps; starting anew", folder, most_steps)
        return None
    return found


def _numbers(folder: Path) -> list[int]:
    """Return the numbers of the JSON files, the latest first."""
    matches = (_NAME.fullmatch(name) for name in PlainFolder(folder).names())
    return sorted((int(m[2]) for m in matches if m and m[1] == "checkpoint"), reverse=True)


def _index_path(folder: Path, number: int) -> Path:
    return folder / f"checkpoint-{number}.json"


def _index(folder: Path, number: int) -> dict[str, Any] | None:
    """Return what a JSON file says, `None` where it is not what was written."""
    try:
        index = json.loads(_index_path(folder, number).read_text(encoding="utf-8"))
        if not isinstance(index, dict) or index.pop("digest", None) != _digest(index):
            raise ValueError("it does not match its digest")
        if index["version"] != VERSION or index["number"] != number:
            raise ValueError("it is of another version, or was given another name")
    except (OSError, ValueError, KeyError, RecursionError) as error:
        _warn(folder, error)
        return None
    return index


def _warn(folder: Path, error: Exception) -> None:
    log.warning("the checkpoint in %s cannot be read (%s); starting anew", folder, error)


def _digest(index: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(index, sort_keys=True).encode()).hexdigest()


def _file_digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
