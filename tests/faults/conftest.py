"""An undisturbed run, which every disturbed one has to end like, and a command line to disturb."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from quick_run import SMOKE, ended, environment
from told import Command, Said

from robomore.cli.app import main
from robomore.evaluation import evaluator


@pytest.fixture(scope="session")
def timed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, float]:
    out = tmp_path_factory.mktemp("undisturbed") / "run"
    began = time.monotonic()
    done = ended(*SMOKE, "--workers", "2", "--out", out)
    assert done.returncode == 0, done.stderr
    return out, time.monotonic() - began


@pytest.fixture(scope="session")
def undisturbed(timed: tuple[Path, float]) -> Path:
    """Folder of the run."""
    return timed[0]


@pytest.fixture(scope="session")
def undisturbed_seconds(timed: tuple[Path, float]) -> float:
    """How long it took."""
    return timed[1]


@pytest.fixture
def robomore_(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Command:
    """Run a command in this process, with the quick trainer in its workers."""
    monkeypatch.setattr(evaluator, "_WORK", "quick_run:work")
    monkeypatch.setenv("PYTHONPATH", environment()["PYTHONPATH"])

    def call(*arguments: str | Path) -> Said:
        capsys.readouterr()
        status = main([str(argument) for argument in arguments])
        return Said(status, *capsys.readouterr())

    return call
