"""Undisturbed runs, which every disturbed one has to end like, and a command line to disturb."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from quick_run import SMOKE, ended, environment
from refusals import Command, Said

from robomore.cli.app import main
from robomore.evaluation import evaluator
from robomore.report import page
from shared import made_once


def _run(out: Path, work: str) -> None:
    done = ended(*SMOKE, "--workers", "2", "--out", out, work=work)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a run whose numbers are made up. Copy it before you write to it."""
    return made_once(tmp_path_factory, "undisturbed", lambda out: _run(out, "made_up"))


@pytest.fixture(scope="session")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a run with the quick trainer, and in `seconds` how long it took."""

    def timed(folder: Path) -> None:
        began = time.monotonic()
        _run(folder / "run", "quick")
        (folder / "seconds").write_text(str(time.monotonic() - began))

    return made_once(tmp_path_factory, "trained", timed)


@pytest.fixture
def robomore_(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Command:
    """Run a command in this process, with made-up evaluations in its workers."""
    monkeypatch.setattr(evaluator, "_WORK", "quick_run:made_up")
    monkeypatch.setattr(page, "recorded", lambda run, key, name: None)  # it takes seconds
    monkeypatch.setenv("PYTHONPATH", environment()["PYTHONPATH"])

    def call(*arguments: str | Path) -> Said:
        capsys.readouterr()
        status = main([str(argument) for argument in arguments])
        return Said(status, *capsys.readouterr())

    return call
