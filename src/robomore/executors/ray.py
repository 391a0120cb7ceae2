"""Jobs on a Ray cluster: one task each, that hands its job to a worker process on its machine.

Jobs and replies travel by value. The driver gives Ray at most as many jobs as the cluster holds, so
that a stop means a stop, and a machine that is not fit for the work gets no more of it. What a lost
machine was busy with is done again; a job has no effect but its reply, so nothing counts twice.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence

from robomore.executors.executor import Carry, Outcome, Progress, never
from robomore.executors.ray_batch import Batch
from robomore.executors.ray_cluster import connect, ray_module
from robomore.executors.ray_node import serve
from robomore.executors.ray_nodes import Nodes
from robomore.executors.resources import Resources
from robomore.executors.workers import Workers


class Ray:
    """Runs jobs on the machines of a Ray cluster.

    Args:
        workers: most jobs at once; by default as many as the machines of the cluster hold.
        address: of the cluster, `auto` or `HOST:PORT`; `None` starts one on this machine, which
            ends with `close`.
        resources: that are reserved for each job.

    Raises:
        InputError: Ray or the cluster cannot be used, or no machine has those resources.
    """

    def __init__(
        self,
        workers: int | None = None,
        address: str | None = None,
        resources: Resources | None = None,
    ) -> None:
        resources = resources or Resources()
        connect(address)
        ray = ray_module()
        try:
            self._nodes = Nodes(resources)
            if workers is None:
                self._nodes.refuse_too_small()
            self._asked = workers
            self._workers = Workers(self._most)
            self._remote = ray.remote(
                num_returns="streaming",
                num_cpus=resources.cores,
                memory=resources.memory_bytes,
                num_gpus=resources.gpu_share,
                # A lost job is given again by the driver, which knows where it must not go.
                max_retries=0,
            )(serve)
        except BaseException:
            ray.shutdown()
            raise
        self._closed = False

    @property
    def workers(self) -> int:
        """How many jobs run at once: what was asked for, or what the cluster holds now."""
        return max(1, self._workers.count)

    def _most(self) -> int:
        """Return how many jobs may be with Ray now: none where all it could do is wait for ever."""
        return 0 if self._nodes.hopeless() else self._asked or self._nodes.capacity()

    def map(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Progress,
        timeout: float,
        should_stop: Callable[[], bool] = never,
    ) -> Generator[tuple[int, Outcome]]:
        """See `Executor.map`."""
        return self.map_remote(function, payloads, progress, timeout, should_stop)

    def map_remote(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Progress,
        timeout: float,
        should_stop: Callable[[], bool] = never,
        carry: Sequence[Carry | None] = (),
    ) -> Generator[tuple[int, Outcome]]:
        """See `RemoteExecutor.map_remote`. Interrupting the iteration kills its jobs."""
        if self._closed:
            raise RuntimeError("the executor is closed; make a new one")
        batch = Batch(
            self._remote,
            self._nodes,
            self._workers,
            function,
            payloads,
            carry,
            timeout,
            should_stop,
        )
        yield from batch.outcomes(progress)

    def close(self) -> None:
        """Leave the cluster. Ray kills what still runs for this process."""
        if not self._closed:
            self._closed = True
            ray_module().shutdown()
