"""Files that untrusted code may have written are read without trusting them."""

from __future__ import annotations

import io
import os
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest

from robomore.sandbox.untrusted_files import UntrustedFileError, read_arrays, read_file


def test_plain_files_come_out(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"content")
    assert read_file(tmp_path / "a", 7) == b"content"
    with pytest.raises(UntrustedFileError, match="more than 6"):
        read_file(tmp_path / "a", 6)


def test_arrays_come_out(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", x=np.arange(3, dtype="f4"), y=np.eye(2, dtype="f4"))
    arrays = read_arrays(tmp_path / "a.npz", 10_000, 2)
    np.testing.assert_array_equal(arrays["x"], [0, 1, 2])
    assert arrays["y"].shape == (2, 2)


def test_links_pipes_folders_and_nothing(tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("secret")
    # Its target has one name, so that the link itself has to be what is refused.
    (tmp_path / "other").write_text("secret")
    (tmp_path / "link").symlink_to(tmp_path / "other")
    os.link(tmp_path / "secret", tmp_path / "second")
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    for name in ("link", "second", "pipe", "folder", "missing"):
        with pytest.raises(UntrustedFileError):
            read_file(tmp_path / name, 1000)


def test_a_deflated_array_is_refused_however_small(tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "a.npz", x=np.zeros(3, "f4"))
    with pytest.raises(UntrustedFileError, match="not what NumPy writes"):
        read_arrays(tmp_path / "a.npz", 10_000, 8)


def test_bombs_and_pickles(tmp_path: Path) -> None:
    bomb = tmp_path / "bomb.npz"
    np.savez_compressed(bomb, x=np.zeros(10**6))
    pickled = tmp_path / "pickled.npz"
    np.savez(pickled, x=np.array([{}], dtype=object))
    huge = tmp_path / "huge.npz"
    header = io.BytesIO()
    claims = {"descr": "<f8", "fortran_order": False, "shape": (10**11,)}
    np.lib.format.write_array_header_1_0(header, claims)
    with zipfile.ZipFile(huge, "w") as archive:
        archive.writestr("x.npy", header.getvalue())
    text = tmp_path / "text.npz"
    text.write_text("no archive")
    for path in (bomb, pickled, huge, text):
        with pytest.raises(UntrustedFileError):
            read_arrays(path, 100_000, 8)


@pytest.mark.parametrize(
    "array",
    [
        np.zeros(3),
        np.zeros(3, "<f2"),
        np.zeros(3, ">f4"),
        np.zeros(3, "<i4"),
        np.zeros(3, "<c8"),
        np.zeros(3, "<M8[s]"),
        np.zeros(3, "<U4"),
        np.zeros(3, [("a", "<f4")]),
        np.float32(1),
        np.zeros((0, 4), "<f4"),
        np.zeros((2, 2, 2), "<f4"),
        np.asfortranarray(np.zeros((2, 3), "<f4")),
    ],
    ids=lambda array: f"{array.dtype.str}{array.shape}",
)
def test_only_matrices_and_vectors_of_float32_are_read(tmp_path: Path, array: np.ndarray) -> None:
    np.savez(tmp_path / "a.npz", x=array)
    with pytest.raises(UntrustedFileError):
        read_arrays(tmp_path / "a.npz", 10_000, 8)


@pytest.mark.parametrize(
    "header",
    [
        "{'descr': '<f4', 'fortran_order': False, 'shape': " + "(" * 2000,
        "{'descr': '<f4', 'fortran_order': False, 'shape': (3,), } or {}",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (-3,), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (999999999999,), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 1, 1), }",
        "{'descr': '<f4'",
        "3L",
        "",
    ],
)
def test_a_header_is_never_evaluated(tmp_path: Path, header: str) -> None:
    length = len(header).to_bytes(2, "little")
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("x.npy", b"\x93NUMPY\x01\x00" + length + header.encode() + bytes(12))
    with pytest.raises(UntrustedFileError, match="header"):
        read_arrays(tmp_path / "a.npz", 10_000, 8)


def test_an_archive_is_bounded_and_has_each_name_once(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez(path, **{f"x{i}": np.zeros(1, "<f4") for i in range(9)})
    with pytest.raises(UntrustedFileError, match="too many"):
        read_arrays(path, 100_000, 8)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("x.npy", b"")
        archive.infolist()[0].extra = bytes(60_000)  # in the list at the end alone
    with pytest.raises(UntrustedFileError, match="too many"):
        read_arrays(path, 100_000, 8)
    content = io.BytesIO()
    np.save(content, np.zeros(3, "<f4"))
    for names in (("x.npy", "x.npy"), ("x",), ("x.txt",)):
        with warnings.catch_warnings(), zipfile.ZipFile(path, "w") as archive:
            warnings.simplefilter("ignore")
            for name in names:
                archive.writestr(name, content.getvalue())
        with pytest.raises(UntrustedFileError, match="not what NumPy writes"):
            read_arrays(path, 100_000, 8)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("x.npy", content.getvalue() + b"more")
    with pytest.raises(UntrustedFileError, match="does not fit"):
        read_arrays(path, 100_000, 8)


@pytest.mark.parametrize("seed", range(30))
def test_damage_is_suspicious_or_harmless(tmp_path: Path, seed: int) -> None:
    np.savez(tmp_path / "a.npz", x=np.arange(50, dtype="f4"))
    content = bytearray((tmp_path / "a.npz").read_bytes())
    rng = np.random.default_rng(seed)
    for _ in range(5):
        content[rng.integers(len(content))] = rng.integers(256)
    (tmp_path / "a.npz").write_bytes(content)
    try:
        arrays = read_arrays(tmp_path / "a.npz", 10_000, 8)
    except UntrustedFileError:
        return
    assert all(array.nbytes <= 10_000 for array in arrays.values())
