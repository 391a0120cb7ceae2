"""Files in a folder that may come from somebody else: nothing leads out of it, nothing hangs."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from robomore.plain_files import NotPlainError, PlainFolder, is_plain_name, scratch_folder


@pytest.fixture
def outside(tmp_path: Path) -> Path:
    """A folder of somebody else, which nothing may touch."""
    folder = tmp_path / "outside"
    (folder / "inner").mkdir(parents=True)
    (folder / "precious").write_text("precious")
    (folder / "inner" / "deep").write_text("precious")
    return folder


@pytest.fixture
def folder(tmp_path: Path) -> PlainFolder:
    (tmp_path / "run").mkdir()
    return PlainFolder(tmp_path / "run")


def whole(outside: Path) -> bool:
    return all((outside / name).read_text() == "precious" for name in ("precious", "inner/deep"))


def make_socket(path: Path, outside: Path) -> None:
    with closing(socket.socket(socket.AF_UNIX)) as made:
        made.bind(str(path))


KINDS: dict[str, Callable[[Path, Path], object]] = {
    "link to a file": lambda path, outside: path.symlink_to(outside / "precious"),
    "link to a folder": lambda path, outside: path.symlink_to(outside),
    "link to nothing": lambda path, outside: path.symlink_to(outside / "new"),
    "pipe": lambda path, outside: os.mkfifo(path),
    "socket": make_socket,
}


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_not_plain_is_neither_read_nor_written_nor_entered(
    folder: PlainFolder, outside: Path, kind: str
) -> None:
    KINDS[kind](folder.path / "x", outside)
    for use in (
        lambda: folder.read("x"),
        lambda: folder.write("x", b"changed"),
        lambda: folder.kind("x"),
        lambda: folder.is_file("x"),
        lambda: folder.make("x"),
        lambda: folder.make("x/new"),
        lambda: folder.names("x"),
        lambda: folder.check(),
        lambda: folder.read("x/precious"),
        lambda: folder.write("x/precious", b"changed"),
        lambda: folder.remove("x/precious"),
        lambda: folder.remove("x/inner"),
        lambda: PlainFolder(folder.path / "x", follow=False).write("new", b""),
    ):
        with pytest.raises(RUNS_OUT):
            use()
    assert whole(outside) and PlainFolder(outside).names() == ["inner", "precious"]
    folder.remove("x")
    assert whole(outside) and not folder.names()


RUNS_OUT = (NotPlainError, NotADirectoryError)


def test_a_link_deep_in_a_folder_is_removed_and_not_followed(
    folder: PlainFolder, outside: Path
) -> None:
    folder.make("a/b/c")
    (folder.path / "a/b/c/x").symlink_to(outside)
    (folder.path / "a/b/y").symlink_to(outside / "precious")
    with pytest.raises(NotPlainError, match="symbolic link"):
        folder.check(depth=3)
    folder.remove("a")
    assert whole(outside) and not folder.names()


def test_a_folder_moves_into_the_place_of_another(folder: PlainFolder, outside: Path) -> None:
    folder.make("new")
    folder.write("new/a", b"1")
    (folder.path / "old").symlink_to(outside)
    folder.replace("new", "old")
    assert folder.read("old/a") == b"1" and whole(outside)


def test_only_whole_files_of_bounded_size_are_read_and_written(folder: PlainFolder) -> None:
    folder.write("a", b"12345")
    folder.write("a", b"123456")
    assert folder.read("a", 6) == b"123456"
    with pytest.raises(NotPlainError, match="more than 5 bytes"):
        folder.read("a", 5)
    with pytest.raises(TypeError):
        folder.write("a", "no bytes")  # type: ignore[arg-type]
    assert folder.names() == ["a"]
    assert folder.kind("none") is None and not folder.is_file("none")


@pytest.mark.parametrize(
    "name", ["", ".", "..", "../x", "a/../../x", "/etc/passwd", "a\0b", "a//b"]
)
def test_names_lead_nowhere_else(folder: PlainFolder, name: str) -> None:
    assert not all(map(is_plain_name, name.split("/")))
    for use in (folder.read, folder.remove, folder.kind, lambda name: folder.write(name, b"")):
        with pytest.raises(NotPlainError):
            use(name)


def test_folders_nested_without_end_or_closed_to_their_owner_are_removed(
    folder: PlainFolder,
) -> None:
    with scratch_folder(folder.path, "a-") as scratch:
        nest(scratch)
    assert not folder.names()


def nest(scratch: Path) -> None:
    """Do with a scratch folder what untrusted code may do."""
    descriptor = os.open(scratch, os.O_RDONLY)
    for _ in range(1_200):
        os.mkdir("d", dir_fd=descriptor)
        os.close(os.open("f", os.O_CREAT, dir_fd=descriptor))
        inner = os.open("d", os.O_RDONLY, dir_fd=descriptor)
        os.close(descriptor)
        descriptor = inner
    os.mkdir("closed", dir_fd=descriptor)
    os.close(os.open("closed/f", os.O_CREAT, dir_fd=descriptor))
    os.chmod("closed", 0o000, dir_fd=descriptor)
    os.close(descriptor)
