"""Folders that travel: whole, plain, and of bounded size."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from robomore.errors import RunFolderError, UnfitWorker
from robomore.executors.carried import carried_folder, packed, unpack


def test_a_folder_arrives_as_it_was(tmp_path: Path) -> None:
    (tmp_path / "from").mkdir()
    (tmp_path / "from" / "arrays-1.npz").write_bytes(bytes(range(256)))
    (tmp_path / "from" / "checkpoint-1.json").write_text('{"number": 1}\n')
    content = packed(tmp_path / "from")
    assert content is not None
    unpack(content, tmp_path / "to")
    for file in (tmp_path / "from").iterdir():
        assert (tmp_path / "to" / file.name).read_bytes() == file.read_bytes()
    assert packed(tmp_path / "missing") is None


def test_a_link_in_a_folder_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("secret")
    (tmp_path / "from").mkdir()
    (tmp_path / "from" / "link").symlink_to(tmp_path / "secret")
    with pytest.raises(RunFolderError):
        packed(tmp_path / "from")


def test_a_name_that_is_no_text_costs_a_checkpoint_and_no_machine(tmp_path: Path) -> None:
    (tmp_path / "checkpoint-1.json").write_text("{}")
    assert packed(tmp_path) is not None
    (Path(os.fsdecode(os.fsencode(tmp_path) + b"/left-\xff"))).write_text("x")
    assert packed(tmp_path) is None


@pytest.mark.parametrize(
    "content",
    [b'[["../up",1]]\nx', b'[["a",5]]\nx', b'[["a",-1]]\n', b"no end of line", b"{}\n"],
)
def test_what_nobody_packed_is_refused(content: bytes, tmp_path: Path) -> None:
    with pytest.raises(ValueError):
        unpack(content, tmp_path / "to")
    assert not (tmp_path / "up").exists()


def test_a_job_finds_its_folder_where_nobody_else_can_write(tmp_path: Path) -> None:
    folder = carried_folder("one", tmp_path)
    unpack(b'[["a",1]]\nx', folder)
    assert carried_folder("one", tmp_path) == folder and (folder / "a").read_bytes() == b"x"
    for one in (folder, folder.parent):
        assert stat.S_IMODE(one.stat().st_mode) == 0o700
    with pytest.raises(ValueError, match="no name of a carried folder"):
        carried_folder("../one", tmp_path)


def test_what_somebody_put_in_the_place_of_the_folder_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = carried_folder("one", tmp_path).parent
    place.chmod(0o777)
    with pytest.raises(UnfitWorker, match="no folder that only you can use"):
        carried_folder("one", tmp_path)
    place.rmdir()
    (tmp_path / "elsewhere").mkdir(mode=0o700)
    place.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(UnfitWorker, match="set TMPDIR to a folder of your own"):
        carried_folder("one", tmp_path)
    place.unlink()
    place.mkdir(mode=0o700)
    owner = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
    place.rename(tmp_path / f"robomore-carried-{owner + 1}")
    with pytest.raises(UnfitWorker, match="no folder that only you can use"):
        carried_folder("one", tmp_path)
