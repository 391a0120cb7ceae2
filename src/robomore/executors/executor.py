"""What the evaluator asks of an executor."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import Protocol

Work = Callable[[bytes, Callable[[int], None]], bytes]
"""A job's function: payload and a way to report progress in, reply out. Raises if broken."""


@dataclass(frozen=True, slots=True)
class Done:
    """The function returned."""

    reply: bytes


@dataclass(frozen=True, slots=True)
class Failed:
    """No reply came.

    Attributes:
        reason: what happened, for people.
        timed_out: the job used up its time.
        unstarted: there was no process to run it, which is no fault of the job's.
    """

    reason: str
    timed_out: bool = False
    unstarted: bool = False


Outcome = Done | Failed
Progress = Callable[[int, int], None]
"""Told (job's index, units done); the first call for a job, with 0, says that it has started."""


def never() -> bool:
    """Return `False`: the jobs are not to be stopped."""
    return False


class Executor(Protocol):
    """Runs jobs of one function."""

    workers: int

    def map(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Progress,
        timeout: float,
        should_stop: Callable[[], bool] = never,
    ) -> Generator[tuple[int, Outcome]]:
        """Yield (index, outcome) of each payload as it finishes, in no particular order.

        Args:
            function: `module:name` of a `Work` function.
            payloads: one per job.
            progress: told what goes on; called in this thread.
            timeout: seconds after which a job is given up and its worker killed.
            should_stop: asked before each job starts. Once it returns `True`, no further job
                starts; jobs under way finish and are yielded, those that have not started are
                not. It may be called from several threads at once.
        """
        ...

    def close(self) -> None:
        """Stop all workers, whatever they do."""
        ...


def load(function: str) -> Work:
    """Import `module:name`."""
    module, name = function.split(":")
    work: Work = getattr(importlib.import_module(module), name)
    return work
