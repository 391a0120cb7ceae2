"""A real Ray cluster of two nodes on this machine: what happens to one does not change a number."""

from __future__ import annotations

import importlib
import os
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from threading import Thread
from typing import Any

import pytest
from ray_cluster import (
    command,
    kill_at_work,
    memory_holds,
    ray_cluster,
    ray_processes,
    until_none_is_left,
)

from robomore import load_run
from robomore.errors import InputError
from robomore.events import Event, Finished
from robomore.executors import Done, Failed
from robomore.executors.executor import Carry, RemoteExecutor
from robomore.executors.ray import Ray
from robomore.executors.ray_cluster import connect
from robomore.options import with_options
from robomore.settings import RunSettings, preset, with_method
from robomore.studies import Arm, Study
from robomore.studies.execute import cells_of, run_study
from robomore.studies.presets import Scale
from robomore.testing.executors import check_executor
from tiny import TINY, numbers

pytestmark = pytest.mark.skipif(find_spec("ray") is None, reason="needs the extra ray")

PLACES = f"{Path(__file__).parent}:{Path(__file__).parents[1]}"
PLANTED = "sk-planted-" + "k" * 24

SCREENED = with_method(
    replace(TINY, evaluations=4),
    None,
    {"screening": "halving", "rungs": [{"budget_fraction": 0.5, "keep_fraction": 0.5}]},
)
STUDY = Study("small", "", (Arm("robomore"), Arm("random", {"method": "random"})), lambda r: [])


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", PLACES)
        with ray_cluster(2) as started:
            yield started
    assert not until_none_is_left()


@pytest.fixture(scope="module")
def executor(cluster: Any) -> Iterator[Ray]:
    """Joins the cluster once the contract has been checked: a process is in one at most."""
    with closing(Ray(None, cluster.address)) as made:
        yield made


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("127.0.0.1:1", "nothing answers there"),
        ("somewhere", "it is no HOST:PORT"),
        ("ray://127.0.0.1:10001", "Ray's client protocol is not used"),
    ],
)
def test_an_address_without_a_cluster_is_refused_at_once(address: str, said: str) -> None:
    began = time.monotonic()
    with pytest.raises(InputError, match=f"--ray-address {address}: {said}"):
        connect(address)
    assert time.monotonic() - began < 30


def outcomes(executor: Ray, name: str, payloads: list[bytes]) -> list[object]:
    found = dict(executor.map(f"jobs:{name}", payloads, lambda index, units: None, 900))
    return [found[index] for index in range(len(payloads))]


def test_keys_stay_with_the_driver(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PYTHONPATH", PLACES)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("OPENAI_API_KEY", PLANTED)
    monkeypatch.setenv("RAY_worker_niceness", "0")
    with closing(Ray(1)) as executor:
        assert os.environ["OPENAI_API_KEY"] == PLANTED
        ((_, seen),) = executor.map(
            "jobs:everything_around", [str(os.getpid()).encode()], lambda i, units: None, 900
        )
        assert isinstance(seen, Done) and seen.reply.count(b"PATH=") > 2
        assert PLANTED.encode() not in seen.reply
        name = importlib.import_module("ray").get_runtime_context().get_session_name()
        session = Path("/tmp/ray") / name
        # Job descriptions and small objects lie in the memory of these.
        processes = [
            one for one in ray_processes() if command(one).endswith((b"gcs_server", b"raylet"))
        ]
        assert len(processes) == 2
        for process in processes:
            assert not memory_holds(process, PLANTED.encode()), process
    logs = list(session.rglob("*"))
    assert logs
    for file in logs:
        assert not file.is_file() or PLANTED.encode() not in file.read_bytes(), file
    token = tmp_path / ".ray" / "auth_token"
    assert token.stat().st_mode & 0o077 == 0, "others on this machine may read the token"
    assert not until_none_is_left()


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


def test_what_a_slow_node_is_busy_with_is_done_elsewhere(
    executor: Ray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robomore.executors.ray_batch._LEAST_SECONDS", 0.5)
    (tmp_path / "quick").touch()
    slow = f"slow {tmp_path / 'once'}".encode()
    payloads = [slow, *[f"slow {tmp_path / 'quick'}".encode()] * 4]
    assert outcomes(executor, "once", payloads) == [Done(b"done")] * 5


def test_a_folder_travels_from_job_to_job_and_can_be_lost(executor: Ray) -> None:
    def counted(left: object, leave: bool = True) -> Done:
        carry = [Carry("some-name", left, leave)]
        ((_, outcome),) = executor.map_remote(
            "jobs:count", [b"some-name"], lambda index, units: None, 900, carry=carry
        )
        assert isinstance(outcome, Done)
        return outcome

    first = counted(None)
    second = counted(first.left)
    assert (first.reply, second.reply) == (b"x", b"xx")
    last = counted(second.left, leave=False)
    assert last.reply == b"xxx" and last.left is None
    assert counted(None).reply == b"x", "nothing stays on the machine"


@pytest.mark.parametrize(
    ("settings", "seeds"),
    [
        pytest.param(
            with_options(preset("smoke"), evaluations=8),
            2,
            id="made up",
            marks=pytest.mark.exhaustive,
        ),
        # The same with trainings, of which screening pauses some.
        pytest.param(SCREENED, 1, id="trained", marks=pytest.mark.exhaustive),
    ],
)
def test_with_a_node_killed_in_the_middle_the_numbers_are_those_of_one_process(
    settings: RunSettings,
    seeds: int,
    cluster: Any,
    executor: Ray,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    if settings is not SCREENED:
        monkeypatch.setattr("robomore.evaluation.evaluator._WORK", "jobs:made_up_work")
    cells = cells_of(STUDY, ["swimmer"], Scale(settings, seeds), seeds)
    victims = list(cluster.worker_nodes)
    cluster.add_node(num_cpus=1)
    keys: list[str] = []

    def kill() -> None:
        for node in victims:
            kill_at_work(cluster, node)

    killer = Thread(target=kill)

    def tell(index: int, cell: object) -> Callable[[Event], None]:
        def observe(event: Event) -> None:
            if isinstance(event, Finished) and not event.known:
                keys.append(event.evaluation.key)
                if len(keys) == 2:
                    killer.start()

        return observe

    run_study(STUDY, cells, tmp_path / "ray", executor=executor, side_by_side=4, tell=tell)
    killer.join()
    assert len(cluster.worker_nodes) == 1
    run_study(STUDY, cells, tmp_path / "inline", executor="inline")
    assert "lost an evaluation, which is done again" in caplog.text
    assert len(keys) > 8
    for cell in cells:
        ours, theirs = tmp_path / "ray" / cell.folder, tmp_path / "inline" / cell.folder
        assert numbers(ours) == numbers(theirs)
        found, expected = load_run(ours).champion, load_run(theirs).champion
        assert found is not None and expected is not None
        assert found.design == expected.design


def test_a_node_that_is_not_fit_gets_no_more_work(
    cluster: Any,
    executor: Ray,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    while executor.workers < 2:
        cluster.add_node(num_cpus=1)
        time.sleep(2)
    payload = f"unfit {tmp_path / 'once'}".encode()
    assert outcomes(executor, "once", [payload]) == [Done(b"done")]
    assert executor.workers == 1
    (said,) = [r.message for r in caplog.records if "gets no work" in r.message]
    assert "it is the first machine" in said
    (nowhere,) = outcomes(executor, "unfit", [b""])
    assert isinstance(nowhere, Failed) and nowhere.unstarted
    assert "no machine is good enough" in nowhere.reason
    # The same with a number of workers, for which Ray would wait until a machine comes.
    monkeypatch.setattr(executor, "_asked", 5)
    for refused in ({}, dict(executor._nodes._refused)):
        monkeypatch.setattr(executor._nodes, "_refused", refused)
        assert [type(one) for one in outcomes(executor, "unfit", [b""] * 8)] == [Failed] * 8
