"""Folders that travel: whole, plain, and of bounded size."""

from __future__ import annotations

from pathlib import Path

import pytest

from robomore.errors import RunFolderError
from robomore.executors.carried import packed, unpack


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


@pytest.mark.parametrize(
    "content",
    [b'[["../up",1]]\nx', b'[["a",5]]\nx', b'[["a",-1]]\n', b"no end of line", b"{}\n"],
)
def test_what_nobody_packed_is_refused(content: bytes, tmp_path: Path) -> None:
    with pytest.raises(ValueError):
        unpack(content, tmp_path / "to")
    assert not (tmp_path / "up").exists()
