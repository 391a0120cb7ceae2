"""A command in this process, and runs to look at that nothing was trained for."""

from __future__ import annotations

from pathlib import Path

import pytest

from cli.commands import Command, Said
from fake_run import finished_run
from robomore.cli import main


@pytest.fixture
def robomore_(capsys: pytest.CaptureFixture[str]) -> Command:
    """Run a command in this process."""

    def run(*arguments: str | Path) -> Said:
        capsys.readouterr()
        status = main([str(argument) for argument in arguments])
        return Said(status, *capsys.readouterr())

    return run


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a whole run that is written by hand; it has no policies."""
    path = tmp_path_factory.mktemp("runs") / "finished"
    finished_run(path)
    return path
