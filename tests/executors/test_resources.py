"""How many evaluations a machine takes, and which clusters take none."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from robomore.errors import InputError
from robomore.executors import ray_nodes
from robomore.executors.ray_nodes import Nodes
from robomore.executors.resources import Resources

GIB = 2**30


@pytest.mark.parametrize(
    ("resources", "count"),
    [
        (Resources(), 8),
        (Resources(cores=0.5), 16),
        (Resources(cores=3), 2),
        (Resources(memory_bytes=5 * GIB), 3),
        (Resources(gpu_share=0.25), 4),
        (Resources(cores=9), 0),
    ],
)
def test_the_scarcest_decides(resources: Resources, count: int) -> None:
    assert resources.fit({"CPU": 8.0, "memory": 16.0 * GIB, "GPU": 1.0}) == count


@pytest.mark.parametrize(
    "wrong", [{"cores": 0}, {"cores": float("nan")}, {"memory_bytes": 1}, {"gpu_share": -1}]
)
def test_nonsense_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="for each evaluation; give"):
        Resources(**wrong)


def test_a_candidate_that_fits_nowhere_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    node = {"NodeID": "a", "Alive": True, "Resources": {"CPU": 2.0, "memory": 4.0 * GIB}}
    dead = {**node, "NodeID": "b", "Alive": False}
    ray = SimpleNamespace(nodes=lambda: [node, dead])
    monkeypatch.setattr(ray_nodes, "ray_module", lambda: ray)
    assert Nodes(Resources()).capacity() == 2
    with pytest.raises(InputError, match="has 3 cores, 1 GiB for an evaluation; the nodes have"):
        Nodes(Resources(cores=3)).refuse_too_small()
