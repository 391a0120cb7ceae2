"""JAX's compilation cache: compiling a trainer takes as long as thousands of training steps."""

from __future__ import annotations

import os

CACHE_VARIABLE = "ROBOMORE_CACHE"
"""Environment variable that names the cache folder; without it nothing is cached."""


def use_cache() -> None:
    """Let JAX read compiled code from the cache folder, and add to it where it may write."""
    folder = os.environ.get(CACHE_VARIABLE)
    if not folder:
        return
    import jax

    for name, value in {
        "jax_compilation_cache_dir": folder,
        # Also what is small or quick to compile, and nothing else of XLA's.
        "jax_persistent_cache_min_compile_time_secs": 0.0,
        "jax_persistent_cache_min_entry_size_bytes": -1,
        # XLA's own caches put the folder's name into the key, and the folder is renamed once full.
        "jax_persistent_cache_enable_xla_caches": "none",
    }.items():
        jax.config.update(name, value)  # type: ignore[no-untyped-call]
