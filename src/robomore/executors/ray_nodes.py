"""The machines of a Ray cluster as the driver sees them: which are fit, and how much they hold."""

from __future__ import annotations

import logging
import threading
import time
from typing import Any

from robomore.errors import InputError
from robomore.executors.ray_cluster import ray_module
from robomore.executors.resources import Resources
from robomore.text import one_line

log = logging.getLogger(__name__)

_LOOK = 1.0
"""Seconds between two looks at the cluster."""
_NODE_ID = "ray.io/node-id"
"""The label that Ray gives every machine."""


class Nodes:
    """What a cluster holds. May be used from several threads.

    Args:
        resources: that are reserved for each job.
    """

    def __init__(self, resources: Resources) -> None:
        self._ray = ray_module()
        self._resources = resources
        self._refused: dict[str, str] = {}
        self._alive: dict[str, dict[str, Any]] = {}
        self._looked = -_LOOK
        self._lock = threading.Lock()

    def capacity(self) -> int:
        """Return how many jobs fit on the machines that are alive and fit for the work."""
        with self._lock:
            self._look()
            return sum(
                self._resources.fit(node["Resources"])
                for id, node in self._alive.items()
                if id not in self._refused
            )

    def refuse(self, id: str, reason: str) -> None:
        """Give no more work to a machine. It is said once why."""
        with self._lock:
            if id in self._refused:
                return
            self._refused[id] = reason
            self._looked = -_LOOK
        log.warning("%s of the cluster gets no work: %s", self.name(id), one_line(reason))

    def options(self, avoid: str = "") -> dict[str, Any]:
        """Return options of a task that keep it away from machines that are not fit.

        Args:
            avoid: one more machine to keep away from; empty for none.
        """
        others = {*self._refused, avoid} - {""}
        if not others:
            return {}
        from ray.util.scheduling_strategies import NodeLabelSchedulingStrategy, NotIn

        strategy = NodeLabelSchedulingStrategy(hard={_NODE_ID: NotIn(*sorted(others))})
        return {"scheduling_strategy": strategy}

    def at(self, ip: str) -> str | None:
        """Return the machine with that address."""
        with self._lock:
            self._look()
            return next((i for i, n in self._alive.items() if n["NodeManagerAddress"] == ip), None)

    def name(self, id: str) -> str:
        """Return the machine's name for people."""
        node = self._alive.get(id, {})
        return f"node {node.get('NodeManagerHostname', '?')} ({id[:8]})"

    def hopeless(self) -> str:
        """Return why waiting does not help: every machine that is there was refused."""
        with self._lock:
            self._look()
            able = [
                id for id, node in self._alive.items() if self._resources.fit(node["Resources"])
            ]
            if not able or any(id not in self._refused for id in able):
                return ""
            why = "; ".join(dict.fromkeys(self._refused[id] for id in able))
        return f"no node of the cluster can do the work: {one_line(why)}"

    def refuse_too_small(self) -> None:
        """Refuse a cluster in which not one job fits anywhere.

        Raises:
            InputError: with what its machines have.
        """
        if self.capacity():
            return
        have = sorted(
            f"{node['Resources'].get('CPU', 0):g} cores, "
            f"{node['Resources'].get('memory', 0) / 2**30:.3g} GiB, "
            f"{node['Resources'].get('GPU', 0):g} GPUs"
            for node in self._alive.values()
        )
        raise InputError(
            f"no node of the Ray cluster has {self._resources} for an evaluation; the nodes have "
            f"{'; '.join(dict.fromkeys(have))}. Give smaller --cores or --memory, or --workers for "
            "a cluster that grows on demand"
        )

    def _look(self) -> None:
        if time.monotonic() - self._looked < _LOOK:
            return
        self._alive = {node["NodeID"]: node for node in self._ray.nodes() if node["Alive"]}
        self._looked = time.monotonic()
