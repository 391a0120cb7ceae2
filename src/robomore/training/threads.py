"""One core per training: many designs are trained side by side, so none may start a thread pool.

Numerical libraries read these settings once, when they load or first compute. A parent therefore
passes `ONE_THREAD` to the processes it starts, and `use_one_thread` covers processes started
without it as far as that is still possible.
"""

from __future__ import annotations

import os

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "VECLIB_MAXIMUM_THREADS": "1",
    # How many workers XLA's client for the CPU makes.
    "NPROC": "1",
}
"""Environment variables for a process that is to compute in one thread."""

_XLA_FLAGS = ("--xla_cpu_multi_thread_eigen=false",)


def use_one_thread() -> None:
    """Make JAX compute in the calling thread alone. To be called before JAX computes anything."""
    for name, value in ONE_THREAD.items():
        os.environ.setdefault(name, value)
    flags = os.environ.get("XLA_FLAGS", "").split()
    os.environ["XLA_FLAGS"] = " ".join([*flags, *(f for f in _XLA_FLAGS if f not in flags)])

    import jax

    # Without this every compiled call is handed to a second thread, only to be waited for.
    jax.config.update("jax_cpu_enable_async_dispatch", False)  # type: ignore[no-untyped-call]
