"""Checkpoints: a folder with one JSON file and the arrays that it names, no code in either.

The JSON file is replaced in one step once the arrays it names are on disk, so a reader finds the
old checkpoint or the new one, whenever the writer dies. It carries digests of the arrays and of
itself, so that a damaged checkpoint counts as none.
"""

from __future__ import annotations

import hashlib
import json
import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

log = logging.getLogger(__name__)

INDEX = "checkpoint.json"
VERSION = 3


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
    before = _index(folder)
    generation = before["generation"] + 1 if before else 0
    files = {part: f"{part}-{generation}.npz" for part in ("arrays", "environment")}
    for part, name in files.items():
        arrays = getattr(checkpoint, part)
        plain: dict[str, Any] = {key: np.asarray(value) for key, value in arrays.items()}
        np.savez(folder / name, allow_pickle=False, **plain)
    index = {"version": VERSION, "generation": generation, "facts": checkpoint.facts, **files}
    index["digests"] = {part: _file_digest(folder / name) for part, name in files.items()}
    temporary = folder / f"{INDEX}.new"
    temporary.write_text(json.dumps(index | {"digest": _digest(index)}), encoding="utf-8")
    temporary.replace(folder / INDEX)
    for path in folder.glob("*.npz"):
        if path.name not in files.values():
            path.unlink()


def load_checkpoint(folder: Path) -> Checkpoint | None:
    """Return what `folder` holds, `None` where there is nothing or nothing that can be read."""
    index = _index(folder)
    if index is None:
        return None
    try:
        parts = []
        for part in ("arrays", "environment"):
            if _file_digest(folder / index[part]) != index["digests"][part]:
                raise ValueError(f"{index[part]} does not match its digest")
            with np.load(folder / index[part], allow_pickle=False) as stored:
                parts.append({name: stored[name] for name in stored.files})
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        log.warning("the checkpoint in %s cannot be read (%s); starting anew", folder, error)
        return None
    return Checkpoint(index["facts"], *parts)


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


def _index(folder: Path) -> dict[str, Any] | None:
    """Return what the JSON file says, `None` where there is none or it is not what was written."""
    try:
        index = json.loads((folder / INDEX).read_text(encoding="utf-8"))
        if not isinstance(index, dict) or index.pop("digest", None) != _digest(index):
            raise ValueError("it does not match its digest")
    except FileNotFoundError:
        return None
    except (OSError, ValueError, RecursionError) as error:
        log.warning("the checkpoint in %s cannot be read (%s); starting anew", folder, error)
        return None
    return index if index.get("version") == VERSION else None


def _digest(index: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(index, sort_keys=True).encode()).hexdigest()


def _file_digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
