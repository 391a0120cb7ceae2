"""Compiling once in a run instead of once in a training: JAX's cache of compiled programs on disk.

What is read from the cache is machine code. So only a process that runs no untrusted code fills it
(`Trainer.prepare`), and it is read-only for a process that does.
"""

from __future__ import annotations

import os
from pathlib import Path

CACHE_VARIABLE = "ROBOMORE_CACHE"
"""Environment variable that names the folder; without it every process compiles for itself."""


def use_cache() -> None:
    """Let JAX read compiled programs from the folder that the environment names, and add to it."""
    folder = os.environ.get(CACHE_VARIABLE)
    if not folder:
        return

    import jax

    options = {
        "jax_compilation_cache_dir": str(Path(folder).absolute()),
        # By default only what took a second to compile is kept.
        "jax_persistent_cache_min_compile_time_secs": 0.0,
        "jax_persistent_cache_min_entry_size_bytes": -1,
        # Paths of autotuning results and kernels are of no use here and would enter the keys.
        "jax_persistent_cache_enable_xla_caches": "none",
    }
    for name, value in options.items():
        jax.config.update(name, value)  # type: ignore[no-untyped-call]
