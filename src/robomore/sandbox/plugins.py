"""Which modules of other packages a sandboxed process has to import: own tasks and trainers.

They lie among the installed packages, or, after `pip install -e`, in somebody's project folder. Of
that folder no more can be read than these modules.
"""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path

from robomore.registry import plugin_entries
from robomore.tasks.own_source import own_source

_GROUPS = ("robomore.tasks", "robomore.trainers", "robomore.fitness")
PACKAGES = ("site-packages", "dist-packages", "lib-dynload")
"""Names of folders for installed packages, which can be read anyway."""


@cache
def plugin_files() -> dict[str, tuple[Path, ...]]:
    """Return the file or folders of each top module that plug-ins consist of, by its name."""
    found: dict[str, tuple[Path, ...]] = {}
    for group in _GROUPS:
        for entry in plugin_entries(group):
            modules = own_source(entry.value.partition(":")[0].strip(), skip=is_installed)
            for top in {module.partition(".")[0] for module in modules}:
                if top != "robomore" and not is_installed(top):
                    found[top] = _places(top)
    return found


def is_installed(top: str) -> bool:
    """Return whether a top module lies in a folder for installed packages."""
    return any(part in PACKAGES for path in _places(top) for part in path.parts)


def _places(top: str) -> tuple[Path, ...]:
    try:
        spec = importlib.util.find_spec(top)
    except (ImportError, ValueError):
        return ()
    if spec is None:
        return ()
    if spec.submodule_search_locations:
        return tuple(map(Path, spec.submodule_search_locations))
    return (Path(spec.origin),) if spec.origin and spec.has_location else ()
