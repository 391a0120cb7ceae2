"""How many jobs an executor runs at once, shared by several batches."""

from __future__ import annotations

import threading
from collections.abc import Callable


class Workers:
    """Counts the workers that are busy. May be used from several threads.

    Args:
        limit: returns how many jobs may run at once now.
    """

    def __init__(self, limit: Callable[[], int]) -> None:
        self._limit = limit
        self._busy = 0
        self._lock = threading.Lock()

    @property
    def count(self) -> int:
        """How many there are now."""
        return self._limit()

    def take(self) -> bool:
        """Take a worker if one is free."""
        limit = self._limit()
        with self._lock:
            if self._busy >= limit:
                return False
            self._busy += 1
            return True

    def give_back(self) -> None:
        """Let another job have the worker."""
        with self._lock:
            self._busy -= 1
