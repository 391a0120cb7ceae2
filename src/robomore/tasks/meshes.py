"""How large the meshes of a robot may be, so that MuJoCo compiles them in seconds."""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping

from robomore.errors import InputError

MOST_BYTES = 16 * 2**20
"""Bytes of one mesh."""

MOST_BYTES_OF_ALL = 64 * 2**20
"""Bytes of all meshes of a task."""

MOST_VERTICES = 100_000
"""Vertices of all meshes. MuJoCo computes a convex hull of each mesh whenever it compiles a model,
which takes up to 12 s for so many vertices (on two circles) and 1 s for those of usual meshes."""

_OBJ_VERTEX = re.compile(rb"^[ \t]*v[ \t]", re.MULTILINE)


def check_meshes(robot: str, assets: Mapping[str, bytes]) -> None:
    """Refuse meshes that are too large, before MuJoCo reads them.

    Args:
        robot: what they are of, for the message.
        assets: content of the files by name.

    Raises:
        InputError: naming the mesh, the number and the limit.
    """
    for name, data in assets.items():
        if len(data) > MOST_BYTES:
            most = MOST_BYTES // 2**20
            raise InputError(
                f"{robot}: the mesh {name!r} has more than {most} MiB; use a simpler one"
            )
    if sum(map(len, assets.values())) > MOST_BYTES_OF_ALL:
        most = MOST_BYTES_OF_ALL // 2**20
        raise InputError(f"{robot}: its meshes have more than {most} MiB; use simpler ones")
    vertices = {name: _vertices(name, data) for name, data in assets.items()}
    if (total := sum(vertices.values())) > MOST_VERTICES:
        name = max(vertices, key=vertices.__getitem__)
        raise InputError(
            f"{robot}: its meshes have {total:,} vertices, of which {name!r} has "
            f"{vertices[name]:,}; the most is {MOST_VERTICES:,}, because MuJoCo computes their "
            "convex hulls for each morphology; simplify them (in Blender: Decimate)"
        )


def _vertices(name: str, data: bytes) -> int:
    """Return how many vertices a mesh file has; 0 for what MuJoCo will not read."""
    ending = name.lower().rpartition(".")[2]
    if ending == "obj":
        return sum(1 for _ in _OBJ_VERTEX.finditer(data))
    if ending == "msh" and len(data) >= 4:
        return max(0, int(struct.unpack_from("<i", data)[0]))
    if ending == "stl" and len(data) >= 84:
        faces = (len(data) - 84) // 50
        if 3 * faces <= MOST_VERTICES:
            return faces // 2 + 2  # of a closed surface
        # Each face is a normal, its corners, and two bytes more.
        starts = range(84 + 12, 84 + 50 * faces, 50)
        corners = (data[at : at + 12] for start in starts for at in range(start, start + 36, 12))
        return len(set(corners))
    return 0
