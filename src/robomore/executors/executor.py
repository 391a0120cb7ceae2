"""The interface of an executor: what it is given, and what it yields."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

JobFunction = Callable[[bytes, Callable[[int], None]], bytes]
"""The function of a job. It takes a payload and a function that reports progress (units done), and
returns a reply. If it raises, the job has failed."""


@dataclass(frozen=True, slots=True)
class Done:
    """The function returned `reply`.

    Attributes:
        reply: what it returned.
        left: stands for the folder that the job left behind on the machine that it ran on, see
            `RemoteExecutor`. `None` where nothing was left.
    """

    reply: bytes
    left: Any = None


@dataclass(frozen=True, slots=True)
class Failed:
    """There is no reply.

    Attributes:
        reason: what happened, as text for people.
        timed_out: whether the job exceeded its time limit.
        unstarted: whether no process could be started for it, which is not the job's fault.
    """

    reason: str
    timed_out: bool = False
    unstarted: bool = False


Outcome = Done | Failed
Progress = Callable[[int, int], None]
"""Called with (index of the job, units done). The first call for a job has 0: it has started."""


def never() -> bool:
    """Return `False`: there is no reason to stop."""
    return False


class Executor(Protocol):
    """Runs jobs."""

    @property
    def workers(self) -> int:
        """How many jobs run at once."""
        ...

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
            function: `module:name` of a `JobFunction`.
            payloads: one for each job.
            progress: called in the thread that iterates, see `Progress`.
            timeout: seconds after which a job is ended and counts as failed.
            should_stop: called before each job starts, possibly from several threads at once.
                Once it returns `True`, no further job starts: jobs that are running finish and
                are yielded, jobs that have not started are not yielded.
        """
        ...

    def close(self) -> None:
        """Stop all workers at once, also those that are running a job. May be called again."""
        ...


@dataclass(frozen=True, slots=True)
class Carry:
    """A folder that a job continues from, and that a later job may continue from.

    Attributes:
        name: of the folder, one component of a path (`robomore.executors.carried`).
        left: what an earlier job left there, as its outcome said; `None` for an empty folder.
        leave: whether this job's folder is kept for a later job.
    """

    name: str
    left: Any = None
    leave: bool = True


@runtime_checkable
class RemoteExecutor(Executor, Protocol):
    """An executor whose jobs may run on machines that share no disk with this one.

    A path of this machine means nothing to its jobs. What a job needs comes with its payload, and
    the folder that it continues from is carried to where it runs. If that folder is lost, with its
    machine for example, the job finds an empty one.
    """

    def map_remote(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Progress,
        timeout: float,
        should_stop: Callable[[], bool] = never,
        carry: Sequence[Carry | None] = (),
    ) -> Generator[tuple[int, Outcome]]:
        """Do what `map` does, with a carried folder for each job or none at all.

        Several threads may iterate at once; they share the workers.
        """
        ...


def load_function(function: str) -> JobFunction:
    """Import `module:name` and return the function."""
    module, name = function.split(":")
    loaded: JobFunction = getattr(importlib.import_module(module), name)
    return loaded
