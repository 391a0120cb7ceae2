"""Compiling once what trainings would each compile anew: a folder of compiled programs.

Tracing, lowering and compiling a round takes longer than a short training. So the finished program
is kept, as JAX serialises it, and the next process loads it (`benchmarks/candidate.py`).

What is loaded is machine code. So only a process that runs no untrusted code fills the folder
(`Trainer.prepare`), and it is read-only for a process that does.
"""

from __future__ import annotations

import hashlib
import os
import pickle
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from robomore.identity import content_key

CACHE_VARIABLE = "ROBOMORE_CACHE"
"""Environment variable that names the folder; without it every process compiles for itself."""

_ENDING = ".program"
_DIGEST = 32
"""Bytes before a program that tell whether it is whole."""


def compiled(name: str, function: Callable[..., Any], *arguments: Any) -> Any:
    """Return `function` compiled for arguments like these; the first argument is overwritten.

    It is read from the folder that the environment names. What is not there yet is compiled, and
    kept there if that is allowed.

    Args:
        name: tells all that `function` depends on besides its arguments and this package's code.
        function: of trees of arrays, as `jax.jit` takes it.
        arguments: only their shapes and types count.
    """
    import jax

    shapes = [
        (np.shape(leaf), str(getattr(leaf, "dtype", type(leaf))))
        for leaf in jax.tree.leaves(arguments)
    ]
    device = jax.devices()[0]
    facts = (jax.__version__, device.platform, device.device_kind, os.environ.get("XLA_FLAGS"))
    key = content_key(name, shapes, facts, training_code())
    if key not in _loaded:
        _loaded[key] = _read(key) or _make(key, function, arguments)
    return _loaded[key]


_loaded: dict[str, Any] = {}


@cache
def training_code() -> str:
    """Return a digest of this package's code, from which the programs are made."""
    files = sorted(Path(__file__).parent.glob("*.py"))
    return content_key([(path.name, path.read_text(encoding="utf-8")) for path in files])


def is_damaged(folder: Path) -> bool:
    """Return whether a program in a folder is not what was written, so that nobody can use it."""
    return any(_whole(path) is None for path in folder.glob(f"*{_ENDING}"))


def _path(key: str) -> Path | None:
    folder = os.environ.get(CACHE_VARIABLE)
    return Path(folder) / f"{key}{_ENDING}" if folder else None


def _read(key: str) -> Any:
    from jax.experimental import serialize_executable

    path = _path(key)
    kept = _whole(path) if path else None
    return serialize_executable.deserialize_and_load(*pickle.loads(kept)) if kept else None


def _whole(path: Path) -> bytes | None:
    """Return the program in a file, `None` if it is damaged: that would give wrong numbers."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    kept = content[_DIGEST:]
    return kept if hashlib.sha256(kept).digest() == content[:_DIGEST] else None


def _make(key: str, function: Callable[..., Any], arguments: Any) -> Any:
    import jax
    from jax.experimental import serialize_executable

    program = jax.jit(function, donate_argnums=0).lower(*arguments).compile()
    path = _path(key)
    if path:
        # A process that may only read the folder has compiled for itself.
        with suppress(OSError):
            kept = pickle.dumps(serialize_executable.serialize(program))
            path.write_bytes(hashlib.sha256(kept).digest() + kept)
    return program
