"""A worker does a job only as whoever asks would have done it."""

from __future__ import annotations

import resource
from dataclasses import replace

import msgspec
import pytest

from robomore.errors import InputError, UnfitWorker
from robomore.evaluation import work as worker
from robomore.evaluation.request import Answer, Request
from robomore.release import VERSION
from robomore.store.manifest import package_versions
from robomore.tasks import get_task
from robomore.tasks.fingerprint import task_key
from robomore.types import Design, Job, Morphology, Reward, Status, TrainerSettings

TASK = get_task("swimmer")
# Refused before training, so that an answer takes no time.
DESIGN = Design(Morphology(TASK.reference), Reward("no program"))
JOB = Job(TASK.id, DESIGN, TrainerSettings("crossq", {}), 100, 1, 0, task_key=task_key(TASK))
FAR = Request(JOB, "k1", "", versions=package_versions("mujoco", "numpy"))
"""A request that came from another machine: no folder is shared."""


@pytest.fixture(autouse=True)
def fresh() -> None:
    worker._refuse_leaks.cache_clear()


def asked(request: Request) -> Answer:
    reply = worker.work(msgspec.json.encode(request), lambda _: None)
    return msgspec.json.decode(reply, type=Answer)


def test_the_same_versions_are_welcome(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker, "ensure", lambda _: None)
    assert asked(FAR).evaluation.status == Status.INVALID_REWARD


def test_the_version_is_that_of_the_code_and_not_of_an_old_installation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("robomore.store.manifest.version", lambda package: "an old one")
    assert package_versions("robomore")["robomore"] == VERSION
    assert package_versions()["mujoco"] == "an old one"


def test_another_version_is_named_and_nothing_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker, "ensure", lambda _: None)
    other = {**FAR.versions, "mujoco": "1.0"}
    with pytest.raises(UnfitWorker, match=r"mujoco 3\.\S+ instead of 1\.0"):
        asked(replace(FAR, versions=other))


def test_a_machine_whose_sandbox_leaks_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def leak(wanted: object) -> None:
        raise InputError(f"no layers for {wanted}")

    monkeypatch.setattr(worker, "ensure", leak)
    with pytest.raises(UnfitWorker, match="no layers for strict"):
        asked(FAR)


def test_another_task_of_the_same_name_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker, "ensure", lambda _: None)
    with pytest.raises(UnfitWorker, match="swimmer"):
        asked(replace(FAR, job=replace(JOB, task_key="0" * 24)))


def test_a_machine_that_cannot_write_blames_no_design(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(worker, "ensure", lambda _: None)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2**20, limits[1]))
    try:
        with pytest.raises(UnfitWorker, match=r"cannot write to \S+ \(File too large\).*TMPDIR"):
            asked(FAR)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
