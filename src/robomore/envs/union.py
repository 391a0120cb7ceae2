"""The material that a robot really takes: where a part runs into its neighbour, it counts once.

The paper's volume adds up the parts, so that overlaps count twice. This is the honest figure next
to it. It needs the optional package `manifold3d`.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING

import mujoco

from robomore.envs.compile import Parameters, compile_model
from robomore.envs.solids import geom_solid, placed
from robomore.tasks.task import Task

if TYPE_CHECKING:
    from manifold3d import Manifold


def union_volume(task: Task, parameters: Parameters) -> float | None:
    """Return the volume of all parts in the initial pose without what neighbours share, in m³.

    Neighbours are parts of one rigid piece and pieces that a joint connects. Parts that merely pass
    through each other, as Walker's two legs do in their plane, are built twice and count twice.
    Accurate to about 0.1 %; a robot without overlaps gives its plain sum exactly.

    Returns:
        `None` if `manifold3d` is not installed.

    Raises:
        InvalidMorphology: as `compile_model`.
    """
    if find_spec("manifold3d") is None:
        return None
    model = compile_model(task, parameters)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    solids: list[Manifold] = []
    pieces: dict[int, Manifold] = {}
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        if body == 0:
            continue
        solid = geom_solid(model, geom)
        solids.append(placed(solid, data.geom_xmat[geom], data.geom_xpos[geom]))
        # Bodies without a joint between them are one rigid piece.
        piece = int(model.body_weldid[body])
        pieces[piece] = pieces[piece] + solids[-1] if piece in pieces else solids[-1]
    filled = 0.0
    for piece, solid in pieces.items():
        parent = int(model.body_weldid[model.body_parentid[piece]])
        filled += (solid - pieces[parent] if parent in pieces else solid).volume()
    # Facets cut a little off every part, off the union as off the sum; the ratio is free of it.
    return float(filled / sum(solid.volume() for solid in solids) * task.volume(parameters))
