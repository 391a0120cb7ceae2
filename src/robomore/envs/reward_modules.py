"""Modules that a reward can import."""

from __future__ import annotations

STANDARD = (
    *("abc", "bisect", "cmath", "collections", "collections.abc", "copy", "dataclasses", "enum"),
    *("functools", "heapq", "itertools", "math", "numbers", "operator", "statistics", "typing"),
)
"""Modules of the standard library that compute and do nothing else."""

MODULES = frozenset(
    (
        *STANDARD,
        *("__future__", "numpy", "numpy.linalg", "numpy.fft", "numpy.typing", "numpy.polynomial"),
    )
)
"""All of them."""
