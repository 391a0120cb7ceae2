"""An own trainer that was edited is another trainer: nothing goes on with both."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

import untrained  # noqa: F401  # known as an executor once it is imported
from robomore import load_run, run
from robomore.errors import RunFolderError, UnfitWorker
from robomore.evaluation.request import Request
from robomore.evaluation.work import work
from robomore.settings import RunSettings, preset, with_method
from robomore.training.settings import (
    TRAINERS,
    Algorithm,
    CrossQSettings,
    _own_code,
    versions_for,
)
from robomore.types import Design, Job, Morphology, Reward, TrainerSettings

OWN = TrainerSettings("own-trainer", {"learning_starts": 1_000})
JOB = Job("swimmer", Design(Morphology((0.1,)), Reward("no program")), OWN, 100, 1, 0)
PROGRAM = "import numpy\nimport own_trainer_parts\n\nclass Trainer: ...\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Somebody's folder with a trainer of two files."""
    (tmp_path / "own_trainer.py").write_text(PROGRAM)
    (tmp_path / "own_trainer_parts.py").write_text("RATE = 0.1\n")
    monkeypatch.syspath_prepend(tmp_path)
    algorithm = Algorithm(CrossQSettings, "own_trainer:Trainer")
    monkeypatch.setitem(TRAINERS._items, OWN.name, algorithm)
    return tmp_path


def settings() -> RunSettings:
    return replace(with_method(preset("smoke"), "random"), trainer=OWN)


@pytest.mark.parametrize("file", ["own_trainer.py", "own_trainer_parts.py"])
def test_the_old_folder_is_refused_and_the_trainer_is_named(file: str, folder: Path) -> None:
    out = folder / "run"
    run("swimmer", settings(), executor="untrained", out=out)
    run("swimmer", settings(), executor="untrained", out=out)  # The same trainer goes on.
    before = {evaluation.key for evaluation in load_run(out).evaluations}

    with (folder / file).open("a") as opened:
        opened.write("FASTER = True\n")
    with pytest.raises(RunFolderError, match=r"trainer own-trainer \w+ there, \w+ here"):
        run("swimmer", settings(), executor="untrained", out=out)
    anew = run("swimmer", settings(), executor="untrained", out=folder / "anew")
    assert not before & {evaluation.key for evaluation in anew.evaluations}


@pytest.mark.parametrize("scratch", ["", "here"], ids=["on another machine", "on this one"])
def test_a_worker_with_another_one_begins_nothing(folder: Path, scratch: str) -> None:
    request = Request(JOB, "k1", scratch and str(folder / scratch), versions=versions_for(OWN))
    (folder / "own_trainer.py").write_text(PROGRAM + "FASTER = True\n")
    with pytest.raises(UnfitWorker, match=r"trainer own-trainer \w+ instead of \w+"):
        work(msgspec.json.encode(request), lambda _: None)


def test_of_packages_their_versions_count_and_not_their_code(folder: Path) -> None:
    (folder / "own_trainer.py").write_text("import jax\n" + PROGRAM)
    assert set(_own_code("own_trainer")) == {"own_trainer", "own_trainer_parts"}
    ours = versions_for(TrainerSettings("crossq"))
    assert set(versions_for(OWN)) - set(ours) == {"trainer own-trainer"}
