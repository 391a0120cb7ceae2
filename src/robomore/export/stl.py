"""Triangles as a binary STL file."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def stl_bytes(vertices: NDArray[np.floating[Any]], faces: NDArray[np.integer[Any]]) -> bytes:
    """Return the content of a file.

    Args:
        vertices: (corners, 3).
        faces: (triangles, 3) indices of corners, counter-clockwise seen from outside.
    """
    corners = np.asarray(vertices, np.float64)[np.asarray(faces)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    triangles = np.zeros(len(corners), _TRIANGLE)
    triangles["normal"] = normals / np.where(lengths > 0, lengths, 1.0)
    triangles["corners"] = corners
    return bytes(80) + len(corners).to_bytes(4, "little") + triangles.tobytes()
