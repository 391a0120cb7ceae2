"""A real Ray cluster of two nodes on this machine: what happens to one does not change a number."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from ray_cluster import ray_cluster, until_none_is_left

from robomore.events import Event, Finished, ignore
from robomore.executors import Done, Failed
from robomore.executors.executor import Carry, RemoteExecutor
from robomore.executors.ray import Ray
from robomore.settings import with_method
from robomore.studies import Arm, Study
from robomore.studies.execute import cells_of, run_study
from robomore.studies.presets import Scale
from robomore.testing.executors import check_executor
from tiny import TINY, numbers

pytestmark = pytest.mark.skipif(find_spec("ray") is None, reason="needs the extra ray")

SCREENED = with_method(
    replace(TINY, evaluations=4),
    None,
    {"screening": "halving", "rungs": [{"budget_fraction": 0.5, "keep_fraction": 0.5}]},
)
STUDY = Study("small", "", (Arm("robomore"), Arm("random", {"method": "random"})), lambda r: [])


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(Path(__file__).parent))
        with ray_cluster(2) as started:
            yield started
    assert not until_none_is_left()


@pytest.fixture(scope="module")
def executor(cluster: Any) -> Iterator[Ray]:
    """Joins the cluster after the contract was checked: a process is in one cluster at most."""
    with closing(Ray(None, cluster.address)) as made:
        yield made


def outcomes(executor: Ray, name: str, payloads: list[bytes]) -> list[object]:
    found = dict(executor.map(f"jobs:{name}", payloads, lambda index, units: None, 120))
    return [found[index] for index in range(len(payloads))]


def test_it_keeps_the_contract(cluster: Any) -> None:
    check_executor(lambda: Ray(2, cluster.address))


def test_jobs_survive_what_happens_around_them(
    executor: Ray, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    assert isinstance(executor, RemoteExecutor) and executor.workers == 2
    payloads = [b"kill", b"print", f"kill {tmp_path / 'once'}".encode()]
    killed, printed = outcomes(executor, "misbehave", payloads[:2])
    assert isinstance(killed, Failed) and "SIGKILL" in killed.reason and not killed.unstarted
    assert printed == Done(b"print")
    assert any("more noise" in record.message for record in caplog.records), "logs reach the driver"
    # Ray's own process dies: that is no fault of the job, which is done again.
    assert outcomes(executor, "once", payloads[2:]) == [Done(b"done")]


def test_a_folder_travels_from_job_to_job_and_can_be_lost(executor: Ray) -> None:
    def counted(left: object, leave: bool = True) -> Done:
        carry = [Carry("some-name", left, leave)]
        ((_, outcome),) = executor.map_remote(
            "jobs:count", [b"some-name"], lambda index, units: None, 120, carry=carry
        )
        assert isinstance(outcome, Done)
        return outcome

    first = counted(None)
    second = counted(first.left)
    assert (first.reply, second.reply) == (b"x", b"xx")
    last = counted(second.left, leave=False)
    assert last.reply == b"xxx" and last.left is None
    assert counted(None).reply == b"x", "nothing stays on the machine"


def test_a_study_with_a_node_killed_in_the_middle_gives_the_numbers_of_one_process(
    cluster: Any, executor: Ray, tmp_path: Path
) -> None:
    cells = cells_of(STUDY, ["swimmer"], Scale(SCREENED, seeds=1), 1)
    victim = cluster.add_node(num_cpus=1)
    finished: list[str] = []

    def tell(index: int, cell: object) -> Callable[[Event], None]:
        def observe(event: Event) -> None:
            if isinstance(event, Finished):
                finished.append(event.evaluation.key)
                if len(finished) == 3:
                    cluster.remove_node(victim, allow_graceful=False)

        return observe

    run_study(STUDY, cells, tmp_path / "ray", executor=executor, side_by_side=2, tell=tell)
    run_study(STUDY, cells, tmp_path / "inline", executor="inline", tell=lambda i, c: ignore)
    assert len(finished) > 6
    for cell in cells:
        ours, theirs = tmp_path / "ray" / cell.folder, tmp_path / "inline" / cell.folder
        assert numbers(ours) == numbers(theirs)
        assert (ours / "champion" / "design.json").read_text() == (
            theirs / "champion" / "design.json"
        ).read_text()


def test_a_node_that_is_not_fit_gets_no_more_work(
    executor: Ray, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    payload = f"unfit {tmp_path / 'once'}".encode()
    assert outcomes(executor, "once", [payload]) == [Done(b"done")]
    assert executor.workers == 1
    (said,) = [r.message for r in caplog.records if "gets no work" in r.message]
    assert "it is the first machine" in said
    (nowhere,) = outcomes(executor, "unfit", [b""])
    assert isinstance(nowhere, Failed) and nowhere.unstarted
    assert "no machine is good enough" in nowhere.reason
