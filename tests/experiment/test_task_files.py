"""A task file in the place of an id: its run's folder needs no other file."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import untrained  # noqa: F401  # known as an executor once it is imported
from dog import write_arm
from robomore import load_run, run
from robomore.errors import RunFolderError
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.settings import preset, with_method
from robomore.tasks import registry


def search(file: Path, out: Path) -> None:
    settings = with_method(preset("smoke"), "random")
    run(str(file), settings, executor="untrained", out=out)


def test_a_run_of_a_task_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_FROM_FILES", {})
    source = write_arm(tmp_path)
    folder, out = tmp_path / "arm", tmp_path / "run"
    file = write_proposal(read_robot(source, "fixed"), source, folder)
    search(file, out)
    search(file, out)  # The same file goes on.

    mesh = folder / "shell.obj"
    mesh.write_text(mesh.read_text().replace("v 0 0 0.1", "v 0 0 0.11"))
    with pytest.raises(RunFolderError, match=r"arm was edited since \(.*assets"):
        search(file, out)

    shutil.rmtree(folder)
    registry._FROM_FILES.clear()
    read = load_run(out)
    assert read.task.assets.keys() == {"shell.obj"} and not read.task_changes
    assert read.champion is not None
    assert read.champion.volume == pytest.approx(
        read.task.volume(read.champion.design.morphology.parameters)
    )
    assert any("length: a link's mass grows" in said for said in read.warnings)
    assert {"task.json", "shell.obj"} <= {path.name for path in (out / "champion").iterdir()}
