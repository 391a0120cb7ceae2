"""An id means one task: no file and no folder changes what the id of another one means."""

from __future__ import annotations

import json
import logging
from pathlib import Path

import pytest

from dog import write_dog
from robomore.errors import InputError
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.task_file import read_task
from robomore.plain_files import PlainFolder
from robomore.runs.loading import stored_task
from robomore.tasks import get_task, registry
from robomore.tasks.portable import task_content
from robomore.tasks.registry import known_task
from robomore.tasks.variants import VARIANTS


@pytest.fixture(autouse=True)
def nothing_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_FROM_FILES", {})


@pytest.fixture
def dog(tmp_path: Path) -> Path:
    source = write_dog(tmp_path)
    return write_proposal(read_robot(source), source, tmp_path / "dog")


def stored(dog: Path, above: Path, **changed: object) -> PlainFolder:
    folder = above / "folder"
    folder.mkdir(exist_ok=True)
    content = json.loads(task_content(read_task(dog))) | changed
    (folder / "task.json").write_text(json.dumps(content))
    return PlainFolder(folder)


@pytest.mark.parametrize("id", ["ant-powered-50", "ant-snow", "ant"])
def test_a_foreign_task_cannot_take_the_id_of_an_installed_one(
    dog: Path, tmp_path: Path, id: str
) -> None:
    files = stored(dog, tmp_path, id=id)
    with pytest.raises(InputError, match=f"'{id}', which is the id of another one; rename it"):
        stored_task(files, id)
    assert known_task(id) is get_task(id) and known_task(id).options is not None
    assert known_task(id).reference == (VARIANTS.get(id) or get_task("ant")).reference


def test_a_task_file_cannot_take_the_id_of_a_side_study(dog: Path) -> None:
    text = dog.read_text()
    assert 'id = "dog"' in text
    dog.write_text(text.replace('id = "dog"', 'id = "ant-hills"'))
    with pytest.raises(InputError, match="'ant-hills', which is the id of another one"):
        get_task(str(dog))
    assert known_task("ant-hills") is VARIANTS["ant-hills"]


def test_a_folder_does_not_change_what_an_id_means(dog: Path, tmp_path: Path) -> None:
    mine = get_task(str(dog))
    foreign = stored_task(stored(dog, tmp_path, title="Foreign"), "dog")
    assert foreign.title == "Foreign" and known_task("dog") is mine

    stored_task(stored(dog, tmp_path, id="cat"), "cat")
    with pytest.raises(InputError, match="cat"):
        known_task("cat")


def test_two_files_with_one_id_are_told_of(dog: Path, caplog: pytest.LogCaptureFixture) -> None:
    other = dog.with_name("other.toml")
    other.write_text(dog.read_text().replace("control_hz = ", "control_hz = 2", 1))
    first = get_task(str(dog))
    with caplog.at_level(logging.WARNING):
        get_task(str(dog))
        assert not caplog.records, "the same file again"
        second = get_task(str(other))
    assert "two tasks with the id 'dog'" in caplog.text
    assert known_task("dog") is second and second.options != first.options
