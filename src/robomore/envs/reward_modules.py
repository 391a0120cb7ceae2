"""Modules that a reward can import, and what of them it cannot use."""

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

OUTSIDE = frozenset(
    (
        *("load", "save", "savez", "savez_compressed", "loadtxt", "savetxt", "genfromtxt"),
        *("fromregex", "fromfile", "tofile", "memmap", "open_memmap", "DataSource"),
        *("get_include", "show_config", "datetime64"),
    )
)
"""Functions of NumPy that read files or the time. The text of a reward may not name them; when it
runs, the sandbox is what keeps it from files."""

SEEDED = frozenset(
    ("default_rng", "PCG64", "PCG64DXSM", "MT19937", "Philox", "SFC64", "SeedSequence")
)
"""What `numpy.random` offers a reward, each with a seed; besides `Generator`."""

DRAW = "it is one generator for everything, and no checkpoint holds it; draw from `self.np_random`"

_REMEMBERS = (
    "it remembers what no checkpoint can hold; compute the value once at the top level, or keep it "
    "in an attribute of `self`"
)

_SETTING = "it changes a setting of all simulations; a reward computes from numbers alone"

_WITHHELD = {
    "numpy": dict.fromkeys(("seterr", "seterrcall", "setbufsize", "set_printoptions"), _SETTING),
    "functools": dict.fromkeys(("cache", "lru_cache", "singledispatch"), _REMEMBERS)
    | {"singledispatchmethod": _REMEMBERS, "get_cache_token": _REMEMBERS},
    "typing": dict.fromkeys(("overload", "get_overloads", "clear_overloads"), _REMEMBERS),
    "abc": {"get_cache_token": _REMEMBERS},
    "statistics": {"kde_random": DRAW},
}


def withheld(module: str, name: str) -> str | None:
    """Return why a reward cannot use a public name of one of its modules, `None` if it can.

    Args:
        module: one of `MODULES`, or `numpy.random`.
        name: of the attribute.
    """
    if module == "numpy.random":
        return None if name in SEEDED or name == "Generator" else DRAW
    return _WITHHELD.get(module.partition(".")[0], {}).get(name)
