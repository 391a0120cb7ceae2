"""What other processes are given of this one's environment, and how their end is told."""

from __future__ import annotations

import os
import signal

_INHERITED = (
    *("PATH", "HOME", "TMPDIR", "TZ", "LANG", "LC_ALL", "LD_LIBRARY_PATH", "PYTHONPATH"),
    *("XDG_CACHE_HOME", "ROBOMORE_CACHE"),
)
"""The environment variables that a process inherits: enough to start Python, and no API key."""


def clean_environment() -> dict[str, str]:
    """Return the variables of this process that another one may inherit: none holds a key."""
    return {name: os.environ[name] for name in _INHERITED if name in os.environ}


def signal_name(number: int) -> str:
    """Return the name of a signal: `SIGKILL`. Those of real time have numbers alone."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
