"""Own tasks that were installed with `pip install -e`: their modules can be imported, no more."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from robomore.sandbox.call import run_sandboxed
from robomore.sandbox.plugins import plugin_files
from robomore.types import Limits, Status
from strict import strictly

pytestmark = strictly


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Somebody's project folder: a task of two modules, and what is nobody's concern."""
    folder, site = tmp_path / "project", tmp_path / "site-packages"
    folder.mkdir()
    (folder / "own_servo_dog.py").write_text("import own_servo_shapes\nTASK = 'the task'\n")
    (folder / "own_servo_shapes.py").write_text("SIZE = 1.0\n")
    (folder / "own_servo_secret.py").write_text("TOKEN = 'secret'\n")
    about = site / "servo_dog-0.1.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: servo-dog\nVersion: 0.1\n")
    (about / "entry_points.txt").write_text("[robomore.tasks]\nservo-dog = own_servo_dog:TASK\n")
    for path in (site, folder):
        monkeypatch.syspath_prepend(str(path))
    importlib.invalidate_caches()
    plugin_files.cache_clear()
    yield folder
    plugin_files.cache_clear()
    for name in ("own_servo_dog", "own_servo_shapes"):
        sys.modules.pop(name, None)


def test_their_modules_are_named_and_nothing_else(project: Path) -> None:
    assert plugin_files() == {
        name: (project / f"{name}.py",) for name in ("own_servo_dog", "own_servo_shapes")
    }


@pytest.mark.parametrize(
    ("asked", "status", "said"),
    [
        ("own_servo_dog.py", Status.OK, ""),
        ("own_servo_secret.py", Status.FAILED, "without -e"),
    ],
)
def test_they_are_read_in_a_sandboxed_process(
    project: Path, tmp_path: Path, asked: str, status: Status, said: str
) -> None:
    ended = run_sandboxed(
        "sandboxed_jobs:import_and_read",
        str(project / asked).encode(),
        tmp_path / "scratch",
        Limits(wall_seconds=30),
        readable=[Path(__file__).parent],
    )
    assert ended.status is status, ended.diagnosis + ended.log
    assert said in ended.diagnosis and (status is not Status.OK or ended.reply == b"the task")
