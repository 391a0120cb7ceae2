"""Trackers: told what a run's events say, and never able to stop it."""

from __future__ import annotations

import logging
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from tensorboardX.proto.event_pb2 import Event as Written
from tensorboardX.record_writer import masked_crc32c

from fake_run import SETTINGS, FakeRun
from robomore.errors import InputError
from robomore.events import Finished, RunBegan, Spent
from robomore.runs import load_run
from robomore.store import Ledger
from robomore.trackers import RunTracking, Tracked
from robomore.trackers.tensorboard import TensorBoard
from robomore.types import Evaluation, Place, Status


class Fake:
    """Stands in for `wandb` and for `trackio`, which have the same three functions."""

    def __init__(self) -> None:
        self.begun: dict[str, Any] = {}
        self.logged: list[tuple[dict[str, float], int]] = []
        self.finished = 0

    def init(self, **options: Any) -> Fake:
        self.begun = options
        return self

    def log(self, values: dict[str, float], step: int) -> None:
        self.logged.append((values, step))

    def finish(self) -> None:
        self.finished += 1


def told(tracking: RunTracking, path: Path) -> None:
    """Tell of a small run: two designs, one of them asked for twice, a failure, a final."""
    run = FakeRun(path)
    tracking(RunBegan("swimmer", "quick", SETTINGS, run.manifest.plan, "offline", "us", 7, 1, path))
    tracking(Spent(requests=3, tokens=500, dollars=None))
    best = run.add(run.reference, Place(stage="coarse", index=(0, 0)), 10.0)
    worse = run.add(run.reference, Place(stage="coarse", index=(0, 1)), 5.0)
    cut = run.add(run.reference, Place(stage="coarse", index=(0, 2)), 50.0, steps=10)
    failed = run.add(
        run.reference, Place(stage="coarse", index=(1, 0)), None, Status.TIMED_OUT, "slow"
    )
    again = run.add(run.reference, Place(stage="final", index=(0,), repeat=1), 9.0)

    def finished(evaluation: Evaluation, stage: str = "coarse") -> Finished:
        return Finished(evaluation, Place(stage=stage, index=(0, 0)), known=False)

    for event in (finished(best), finished(best), finished(worse), finished(cut), finished(failed)):
        tracking(event)
    tracking(finished(again, "final"))
    tracking.close()


@pytest.mark.parametrize("name", ["wandb", "trackio"])
def test_a_tracker_is_told_every_evaluation_once(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake = Fake()
    module = SimpleNamespace(init=fake.init, log=fake.log, finish=fake.finish, __spec__=True)
    monkeypatch.setitem(sys.modules, name, module)  # type: ignore[arg-type]
    monkeypatch.delenv("WANDB_PROJECT", raising=False)
    told(RunTracking([name]), tmp_path / "one")
    assert fake.begun["name"] == "one" and fake.begun["project"] == "robomore"
    assert fake.begun["config"]["method"]["name"] == "robomore"
    assert [step for _, step in fake.logged] == [0, 1, 2, 3, 4, 5]
    values = [values for values, _ in fake.logged]
    assert values[0] == {"llm/requests": 3, "llm/tokens": 500}
    assert values[1]["search/fitness"] == 10.0 and values[2]["search/fitness"] == 5.0
    # A training that was cut short is no new best, and the final is no part of the search.
    assert len({one["search/best_efficiency"] for one in values[1:4]}) == 1
    # The one that was cut short after 10 steps, and a failed one in full.
    assert [one["cost/steps"] for one in values[1:]] == [1_000, 2_000, 2_010, 3_010, 7_010]
    assert values[4]["cost/failed"] == 1 and "search/fitness" not in values[4]
    assert values[5]["final/fitness"] == 9.0 and "search/fitness" not in values[5]
    assert fake.finished == 1


def test_steps_are_those_that_the_run_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake = Fake()
    module = SimpleNamespace(init=fake.init, log=fake.log, finish=fake.finish, __spec__=True)
    monkeypatch.setitem(sys.modules, "wandb", module)  # type: ignore[arg-type]
    run, tracking = FakeRun(tmp_path), RunTracking(["wandb"])
    plan = run.manifest.plan
    tracking(RunBegan("swimmer", "quick", SETTINGS, plan, "offline", "us", 7, 1, tmp_path))
    place = Place(stage="coarse", index=(0, 0))
    first = run.add(run.reference, place, 3.0, steps=200)
    whole = replace(first, key="whole", job=replace(first.job, steps=1_000), steps=1_000)
    failed = run.add(run.reference, place, None, Status.TIMED_OUT, "slow")
    with closing(Ledger(run.folder.ledger)) as ledger:
        ledger.add_place(Place(stage="coarse", index=(0, 1)), whole.key)
        ledger.add_evaluation(whole)
    for one in (first, whole, failed):
        tracking(Finished(one, place, known=False))
    steps = [values["cost/steps"] for values, _ in fake.logged]
    assert steps == [200, 1_000, 2_000]
    assert steps[-1] == load_run(tmp_path).cost.steps


def test_tensorboard_files_lie_in_the_run_folder(tmp_path: Path) -> None:
    told(RunTracking(["tensorboard"]), tmp_path / "one")
    (file,) = (tmp_path / "one" / "tensorboard").iterdir()
    found = [
        (value.tag, written.step, value.simple_value)
        for written in _read(file.read_bytes())
        for value in written.summary.value
    ]
    assert ("search/fitness", 1, 10.0) in found and ("final/fitness", 5, 9.0) in found


def _read(content: bytes) -> list[Written]:
    """Return the events of a file: length, checksum, event, checksum."""
    events, place = [], 0
    while place < len(content):
        length = int.from_bytes(content[place : place + 8], "little")
        body = content[place + 12 : place + 12 + length]
        sum_ = int.from_bytes(content[place + 12 + length : place + 16 + length], "little")
        assert sum_ == masked_crc32c(body)
        events.append(Written.FromString(body))
        place += 16 + length
    return events


def test_a_link_in_a_foreign_folder_is_not_written_through(tmp_path: Path) -> None:
    outside, run = tmp_path / "outside", tmp_path / "one"
    for folder in (outside, run):
        folder.mkdir()
    (run / "tensorboard").symlink_to(outside)
    with pytest.raises(InputError, match="symbolic link"):
        TensorBoard(Tracked(run, "one", {}))
    assert not list(outside.iterdir())


def test_a_tracker_that_fails_is_left_out_with_one_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    broken, good = Fake(), Fake()
    monkeypatch.setattr(broken, "log", lambda *a, **k: 1 / 0)
    for name, fake in (("wandb", broken), ("trackio", good)):
        module = SimpleNamespace(init=fake.init, log=fake.log, finish=fake.finish, __spec__=True)
        monkeypatch.setitem(sys.modules, name, module)  # type: ignore[arg-type]
    with caplog.at_level(logging.WARNING):
        told(RunTracking(["wandb", "trackio"]), tmp_path / "one")
    assert len(good.logged) == 6 and good.finished == 1 and broken.finished == 0
    assert caplog.text.count("the tracker wandb is left out") == 1


def test_what_is_not_there_is_named_before_a_run_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="Did you mean 'tensorboard'"):
        RunTracking(["tensorbord"])
    monkeypatch.setattr("robomore.trackers.tracking.find_spec", lambda name: None)
    with pytest.raises(InputError, match="needs wandb, which is not installed; install it with"):
        RunTracking(["wandb"])
