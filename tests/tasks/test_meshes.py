"""Meshes that MuJoCo would compile for minutes are refused before it reads them."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from robomore.errors import InputError
from robomore.tasks.meshes import MOST_VERTICES, check_meshes


def stl(corners: np.ndarray) -> bytes:
    """Return a file with these corners (n, 3, 3)."""
    faces = np.zeros(
        len(corners), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("end", "<u2")]
    )
    faces["corners"] = corners
    return bytes(80) + struct.pack("<I", len(corners)) + faces.tobytes()


def test_vertices_of_each_kind_of_file_count() -> None:
    count = MOST_VERTICES + 1
    files = {
        "a.obj": b"v 0 0 0\n" * count,
        "a.msh": struct.pack("<4i", count, 0, 0, 1),
    }
    for name, data in files.items():
        with pytest.raises(InputError, match=f"'{name}' has 100,001; the most is 100,000"):
            check_meshes("robot", {name: data})
    with pytest.raises(InputError, match=r"'b\.STL' has 100,002"):
        check_meshes("robot", {"b.STL": stl(np.arange(3.0 * 100_002).reshape(-1, 3, 3))})


def test_usual_meshes_pass_and_add_up() -> None:
    shared = stl(np.zeros((60_000, 3, 3)))
    check_meshes("robot", {"a.stl": shared, "b.obj": b"v 0 0 0\nvn 0 0 1\n" * 50_000})
    half = b"v 0 0 0\n" * (MOST_VERTICES // 2)
    with pytest.raises(InputError, match="100,003 vertices"):
        check_meshes("robot", {"a.obj": half, "b.obj": half + b"v 1 0 0\n" * 3})
