"""The jobs of one call of `Ray.map`, on their way through the cluster."""

from __future__ import annotations

import logging
import time
from collections import deque
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace
from statistics import median
from typing import Any

import msgspec

from robomore.errors import NoWorker
from robomore.executors.executor import Carry, Done, Failed, Outcome, Progress
from robomore.executors.ray_cluster import ray_module
from robomore.executors.ray_node import Ended, Message, Progressed, Started
from robomore.executors.ray_nodes import Nodes
from robomore.executors.workers import Workers
from robomore.text import one_line

log = logging.getLogger(__name__)

_LOOK = 0.5
"""Seconds between two looks whether to stop, and for free workers."""
_MOST_LOSSES = 10
"""Machines or Ray processes that a job may lose before the run stops. It can go on later."""
_PATIENCE = 600.0
"""Seconds to wait for a machine while there is none."""
_SLOW, _LEAST_SECONDS, _KNOWN = 3.0, 20.0, 3
"""A job is copied to a free worker of another machine once it takes so many times the median of the
others, and so many seconds at least, and once so many others are known."""
_REPORTS = 20.0
"""Reports of progress a second, over all jobs of the executor together."""


@dataclass(slots=True)
class _Task:
    """A job that was given to Ray."""

    index: int
    is_copy: bool = False
    node: str = ""
    began: float = 0.0
    copied: bool = False
    ended: Ended | None = None
    cancelled: bool = False


class Batch:
    """Keeps as many jobs with Ray as there are workers, and takes up again what was lost.

    Args:
        remote: Ray's form of `ray_node.serve`.
        nodes: of the cluster.
        workers: shared with other batches.
        function: `module:name` of a `JobFunction`.
        payloads: one for each job.
        carry: the folder of each job, or `None`.
        timeout: seconds for each job.
        should_stop: see `Executor.map`.
    """

    def __init__(
        self,
        remote: Any,
        nodes: Nodes,
        workers: Workers,
        function: str,
        payloads: Sequence[bytes],
        carry: Sequence[Carry | None],
        timeout: float,
        should_stop: Callable[[], bool],
    ) -> None:
        self._ray = ray_module()
        self._remote = remote
        self._nodes = nodes
        self._workers = workers
        self._function = function
        self._payloads = payloads
        self._carry: dict[int, Carry] = {n: one for n, one in enumerate(carry) if one is not None}
        self._timeout = timeout
        self._should_stop = should_stop
        self._waiting = deque(range(len(payloads)))
        self._tasks: dict[Any, _Task] = {}
        self._losses: dict[int, int] = {}
        self._seconds: list[float] = []

    def outcomes(self, progress: Progress) -> Generator[tuple[int, Outcome]]:
        """Yield what comes of each job; those that have not started at a stop are left out.

        Raises:
            NoWorker: the cluster as a whole is lost.
            RuntimeError: the executor was closed meanwhile.
        """
        idle_since = time.monotonic()
        try:
            while self._waiting or self._tasks:
                self._start()
                self._take_back()
                if self._tasks:
                    idle_since = time.monotonic()
                    for generator in self._ready():
                        if generator not in self._tasks:
                            continue  # A copy of it was first.
                        outcome = self._read(generator, progress)
                        if outcome is not None:
                            yield outcome
                elif self._waiting:
                    if why := self._no_way(time.monotonic() - idle_since):
                        yield self._waiting.popleft(), Failed(why, unstarted=True)
                    else:
                        time.sleep(_LOOK / 5)
        except self._ray.exceptions.RayError as error:
            raise NoWorker(
                f"the Ray cluster is lost ({_short(error)}); the same command goes on once it is "
                "back, and everything that was finished is kept"
            ) from error
        finally:
            self._abandon()

    def _start(self) -> None:
        """Give jobs to Ray while workers are free, or none any more if it is time to stop."""
        while self._waiting and self._workers.take():
            if self._should_stop():
                self._workers.give_back()
                self._stop()
                return
            self._give(self._waiting.popleft())
        self._copy_slow()
        if any(not task.node for task in self._tasks.values()) and self._should_stop():
            self._stop()

    def _give(self, index: int, avoid: str = "") -> None:
        """Give Ray a job, or a copy of one that runs on the machine `avoid`."""
        carry = self._carry.get(index)
        options = self._nodes.options(avoid)
        remote = self._remote.options(**options) if options else self._remote
        generator = remote.remote(
            self._function,
            self._payloads[index],
            self._timeout,
            max(1.0, self._workers.count / _REPORTS),
            carry.name if carry else "",
            carry.leave if carry else False,
            carry.left if carry else None,
        )
        self._tasks[generator] = _Task(index, is_copy=bool(avoid))

    def _copy_slow(self) -> None:
        """Let a free worker repeat what a slow machine is busy with: whoever is first has done it.

        Both would give the same reply, so no result depends on who is first.
        """
        if self._waiting or len(self._seconds) < _KNOWN:
            return
        limit = max(_LEAST_SECONDS, _SLOW * median(self._seconds))
        for task in list(self._tasks.values()):
            slow = task.node and not task.is_copy and time.monotonic() - task.began > limit
            if slow and not task.copied and self._workers.take():
                task.copied = True
                self._give(task.index, avoid=task.node)

    def _stop(self) -> None:
        self._waiting.clear()
        for generator, task in self._tasks.items():
            if not task.node and not task.cancelled:
                task.cancelled = True
                self._ray.cancel(generator)

    def _ready(self) -> list[Any]:
        tasks = list(self._tasks)
        # What a job left behind must stay where it is, so nothing is fetched that is not read.
        first, others = self._ray.wait(tasks, timeout=_LOOK, fetch_local=False)
        if not first or not others:
            return list(first)
        more, _ = self._ray.wait(others, num_returns=len(others), timeout=0, fetch_local=False)
        return [*first, *more]

    def _read(self, generator: Any, progress: Progress) -> tuple[int, Outcome] | None:
        """Read one message of a job; return its outcome once it is known."""
        task = self._tasks[generator]
        try:
            reference = next(generator)
            if task.ended is not None:
                return self._over(generator, Done(task.ended.reply or b"", left=reference))
            message = msgspec.json.decode(self._ray.get(reference), type=Message)
        except self._ray.exceptions.TaskCancelledError:
            if task.cancelled:
                self._over(generator, None)
                return None
            return self._lost(generator, "it was cancelled from outside")
        except self._ray.exceptions.RayTaskError as error:
            # The function that passes messages on has failed: that machine is not as it should be.
            node = task.node or self._nodes.at(getattr(error, "ip", ""))
            if node:
                self._nodes.refuse(node, _short(error.cause or error))
            return self._lost(generator, error)
        except self._ray.exceptions.RayError as error:
            return self._lost(generator, error)
        except StopIteration:
            return self._lost(generator, "it ended without an outcome")
        match message:
            case Started(node):
                task.node, task.began = node, time.monotonic()
                if not task.is_copy:
                    progress(task.index, 0)
            case Progressed(units):
                progress(task.index, units)
            case Ended():
                return self._ended(generator, message)
        return None

    def _ended(self, generator: Any, message: Ended) -> tuple[int, Outcome] | None:
        task = self._tasks[generator]
        if message.printed:
            log.warning("%s: %s", self._nodes.name(task.node), one_line(message.printed))
        if message.left:
            task.ended = message
            return None
        if message.reply is not None:
            return self._over(generator, Done(message.reply))
        if message.unstarted:
            self._nodes.refuse(task.node, message.reason)
            self._again(generator)
            return None
        if self._others(task.index)[1:]:
            return self._over(generator, None)  # Its copy may still do it.
        return self._over(generator, Failed(message.reason, message.timed_out))

    def _lost(self, generator: Any, error: object) -> tuple[int, Outcome] | None:
        """Have a job done again whose Ray process, machine or folder is gone."""
        task = self._tasks[generator]
        count = self._losses[task.index] = self._losses.get(task.index, 0) + 1
        if count > _MOST_LOSSES:
            why = f"the cluster lost the same evaluation {count} times, at last by {_short(error)}"
            return self._over(generator, Failed(why, unstarted=True))
        carry = self._carry.get(task.index)
        if carry is not None:
            # The folder may have been on that machine. Without it the numbers are the same.
            self._carry[task.index] = replace(carry, left=None)
        if self._others(task.index)[1:]:
            return self._over(generator, None)
        where = self._nodes.name(task.node) if task.node else "the cluster"
        log.warning("%s lost an evaluation, which is done again: %s", where, _short(error))
        self._again(generator)
        return None

    def _again(self, generator: Any) -> None:
        index = self._tasks[generator].index
        self._over(generator, None)
        if not self._others(index):
            self._waiting.appendleft(index)

    def _others(self, index: int) -> list[Any]:
        return [other for other, task in self._tasks.items() if task.index == index]

    def _over(self, generator: Any, outcome: Outcome | None) -> tuple[int, Outcome] | None:
        task = self._tasks.pop(generator)
        self._workers.give_back()
        if outcome is None:
            return None
        if isinstance(outcome, Done):
            self._seconds.append(time.monotonic() - task.began)
        for other in self._others(task.index):
            self._ray.cancel(other, force=True)
            self._over(other, None)
        return task.index, outcome

    def _take_back(self) -> None:
        """Take back what waits in Ray for a machine if no machine that is there is fit."""
        if self._nodes.hopeless() and not any(task.node for task in self._tasks.values()):
            for generator in list(self._tasks):
                self._ray.cancel(generator, force=True)
                self._again(generator)

    def _no_way(self, seconds: float) -> str:
        """Return why the waiting jobs cannot be started, if it is certain by now."""
        if self._nodes.capacity():
            return ""
        if why := self._nodes.hopeless():
            return why
        return f"the cluster has had no node for {seconds:.0f} s" if seconds > _PATIENCE else ""

    def _abandon(self) -> None:
        for generator in list(self._tasks):
            if self._ray.is_initialized():
                self._ray.cancel(generator, force=True)
            self._over(generator, None)


def _short(error: object) -> str:
    return one_line(str(error))[:300]
