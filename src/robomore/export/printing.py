"""The rigid pieces of a robot as files for a 3D printer, checked before they are called printable.

A piece is everything that moves as one: the parts of bodies without a joint between them. Lengths
are in mm, as printers expect, at a scale that the user chooses.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.solids import geom_solid, placed
from robomore.errors import InputError
from robomore.export.stl import stl_bytes
from robomore.export.urdf import link_names
from robomore.rendering.drawing import rest_pose

if TYPE_CHECKING:
    from manifold3d import Manifold

_MM = 1000.0
_ATTEMPTS = 4
"""How often balls are turned anew until the file is closed."""
_VOLUME_TOLERANCE = 1e-3
"""Relative: files round corners to seven digits."""
_RAYS = 200
"""Places of a surface at which the thickness of a wall is measured."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Printer:
    """What can be printed.

    Attributes:
        scale: size of the print over the size of the robot.
        bed: longest print along three axes, in mm.
        wall: thinnest wall, in mm.
        gap: narrowest gap that stays open, in mm.
    """

    scale: float = 1.0
    bed: tuple[float, float, float] = (256.0, 256.0, 256.0)
    wall: float = 1.2
    gap: float = 0.4

    def check(self) -> None:
        """Refuse numbers that make no sense.

        Raises:
            InputError: naming the option.
        """
        numbers = {"scale": (self.scale,), "bed": self.bed, "wall": (self.wall,)}
        for name, values in (numbers | {"gap": (self.gap,)}).items():
            if not all(0 < value < math.inf for value in values):
                given = ",".join(f"{value:g}" for value in values)
                raise InputError(f"--{name} is {given}; give numbers above 0")


@dataclass(frozen=True, slots=True, kw_only=True)
class Piece:
    """One piece as files, and what was found in them.

    Attributes:
        name: of its first body; `whole` for the whole robot.
        volume: in mm³, overlaps counted once.
        extent: edges in mm of a small box around it, the longest first: of the boxes that fit the
            bed, if any does.
        room: by how much it could be larger and still fit the bed; below 1 if it does not fit.
        wall: its thinnest wall, in mm.
        triangles: of its surface.
        faults: why it cannot be printed; empty if it can.
        stl: content of a file.
        threemf: likewise, as 3MF.
    """

    name: str
    volume: float
    extent: tuple[float, float, float]
    room: float
    wall: float
    triangles: int
    faults: tuple[str, ...]
    stl: bytes
    threemf: bytes

    @property
    def printable(self) -> bool:
        """Whether all checks passed."""
        return not self.faults


def pieces_of(model: mujoco.MjModel, printer: Printer) -> list[Piece]:
    """Return the rigid pieces of a robot, and at last the whole robot at rest.

    Args:
        model: of the robot.
        printer: what can be printed.

    Raises:
        InvalidMorphology: a part has no volume.
    """
    names = link_names(model)

    def piece(body: int) -> Piece:
        return _piece(names[body], lambda turn: _joined(model, printer, turn, body)[0], printer)

    found = [piece(body) for body in _roots(model)]
    thinnest = min(piece.wall for piece in found)

    def whole(turn: int) -> Manifold:
        return _union(_joined(model, printer, turn))

    return [*found, _piece("whole", whole, printer, _too_close(model, printer), thinnest)]


def in_mm(edges: Iterable[float]) -> str:
    """Return the edges of a box in words: `256 x 256 x 200 mm`."""
    return " x ".join(f"{edge:.0f}" for edge in edges) + " mm"


def fitting_scale(pieces: list[Piece], printer: Printer) -> float:
    """Return the largest scale at which every piece fits the bed, down to three digits."""
    return _rounded_down(printer.scale * min(piece.room for piece in pieces))


def _rounded_down(scale: float) -> float:
    step: float = 10.0 ** (math.floor(math.log10(scale)) - 2)
    return math.floor(scale / step) * step


def _roots(model: mujoco.MjModel) -> list[int]:
    """Return the first body of each rigid piece that is part of the robot and has a solid."""
    bodies = {int(model.body_weldid[model.geom_bodyid[geom]]) for geom in _geoms(model)}
    return sorted(bodies)


def _geoms(model: mujoco.MjModel) -> Iterator[int]:
    """Yield the geoms that the robot consists of: of a body those that collide, if there are any.

    The others are for the eye, and often show the same part once more.
    """
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    bodies = set(model.geom_bodyid[collides].tolist())
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        if model.body_weldid[body] and (collides[geom] or body not in bodies):
            yield geom


def _joined(
    model: mujoco.MjModel, printer: Printer, turn: int, only: int | None = None
) -> list[Manifold]:
    """Return each piece as a solid, where it lies at rest; `only` one in its own frame."""
    data = mujoco.MjData(model)
    data.qpos[:] = rest_pose(model)
    mujoco.mj_kinematics(model, data)
    scale = _MM * printer.scale
    solids: dict[int, list[Manifold]] = {}
    for geom in _geoms(model):
        piece = int(model.body_weldid[model.geom_bodyid[geom]])
        if only not in (None, piece):
            continue
        solid = geom_solid(model, geom, scale, turn * model.ngeom + geom)
        solid = placed(solid, data.geom_xmat[geom], data.geom_xpos[geom] * scale)
        if only is not None:
            frame = data.xmat[piece].reshape(3, 3)
            solid = solid.translate(-data.xpos[piece] * scale)
            solid = placed(solid, frame.T, np.zeros(3))
        solids.setdefault(piece, []).append(solid)
    return [_union(solids[piece]) for piece in sorted(solids)]


def _union(solids: list[Manifold]) -> Manifold:
    from manifold3d import Manifold, OpType

    return solids[0] if len(solids) == 1 else Manifold.batch_boolean(solids, OpType.Add)


def _piece(
    name: str,
    make: Callable[[int], Manifold],
    printer: Printer,
    faults: tuple[str, ...] = (),
    wall: float | None = None,
) -> Piece:
    """Return a piece; its balls are turned anew until its files are closed when read again."""
    for turn in range(_ATTEMPTS):
        solid = make(turn)
        mesh = solid.to_mesh()
        vertices, triangles = mesh.vert_properties[:, :3], mesh.tri_verts
        stl, threemf = stl_bytes(vertices, triangles), _threemf(vertices, triangles)
        broken = _broken(solid.volume(), stl, threemf)
        if not broken:
            break
    bed = sorted(printer.bed, reverse=True)
    boxes = _boxes(vertices)
    room = max(_room(box, bed) for box in boxes)
    extent = min((box for box in boxes if room < 1 or _room(box, bed) >= 1), key=math.prod)
    wall = _thinnest(solid) if wall is None else wall
    found = [*broken, *faults]
    if room < 1:
        found.append(f"it is {in_mm(extent)} and the bed {in_mm(bed)}")
    if wall < printer.wall:
        found.append(f"its thinnest wall is {wall:.2f} mm, below {printer.wall:g} mm")
    if (separate := len(solid.decompose())) > 1:
        found.append(f"it falls into {separate} pieces that do not touch")
    return Piece(
        name=name,
        volume=float(solid.volume()),
        extent=extent,
        room=room,
        wall=wall,
        triangles=int(solid.num_tri()),
        faults=tuple(found),
        stl=stl,
        threemf=threemf,
    )


def _broken(volume: float, stl: bytes, threemf: bytes) -> list[str]:
    """Return what is wrong with files, found by reading them again."""
    import trimesh

    found = []
    for kind, content, options in (("stl", stl, {}), ("3mf", threemf, {"process": False})):
        again = trimesh.load_mesh(io.BytesIO(content), file_type=kind, **options)
        if not again.is_watertight:
            found.append(f"its {kind.upper()} file is not closed")
        elif abs(again.volume / volume - 1) > _VOLUME_TOLERANCE:
            found.append(f"its {kind.upper()} file has another volume")
    return found


def _threemf(vertices: NDArray[np.float32], triangles: NDArray[np.uint32]) -> bytes:
    import trimesh

    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    mesh.units = "millimeter"
    content: bytes = mesh.export(file_type="3mf")
    return content


def _room(box: Sequence[float], bed: Sequence[float]) -> float:
    """Return by how much a box can grow within the bed; the edges of both from the longest on."""
    return min(side / edge for edge, side in zip(box, bed, strict=True))


def _boxes(points: NDArray[np.float32]) -> list[tuple[float, float, float]]:
    """Return the edges, from the longest on, of boxes around points that are turned in many ways.

    The smallest is not always the one that fits: a rod that is longer than the bed may lie across.
    """
    centred = points - points.mean(axis=0)
    frames = [np.eye(3), np.linalg.svd(centred.T @ centred)[0]]
    for axis in range(3):
        for angle in np.radians(np.arange(15.0, 90.0, 15.0)):
            turned = np.eye(3)
            others = np.ix_([i for i in range(3) if i != axis], [i for i in range(3) if i != axis])
            sine, cosine = np.sin(angle), np.cos(angle)
            turned[others] = [[cosine, -sine], [sine, cosine]]
            frames.append(turned)
    boxes = []
    for frame in frames:
        longest, middle, shortest = sorted(np.ptp(centred @ frame, axis=0).tolist(), reverse=True)
        boxes.append((longest, middle, shortest))
    return boxes


def _thinnest(solid: Manifold) -> float:
    """Return the thinnest wall in mm: the shortest way through the solid, straight in."""
    mesh = solid.to_mesh()
    corners = mesh.vert_properties[:, :3].astype(np.float64)[mesh.tri_verts]
    inward = -np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(inward, axis=1)
    usable = np.flatnonzero(lengths > 1e-9 * lengths.max())
    middles, reach = corners.mean(axis=1), float(np.ptp(corners.reshape(-1, 3), axis=0).max()) * 2
    thinnest = reach
    for face in usable[:: max(1, len(usable) // _RAYS)].tolist():
        along = inward[face] / lengths[face]
        start = middles[face] + 1e-4 * along
        hits = solid.ray_cast(start.tolist(), (start + reach * along).tolist())
        if hits:
            thinnest = min(thinnest, float(hits[0].distance) * reach)
    return thinnest


def _too_close(model: mujoco.MjModel, printer: Printer) -> tuple[str, ...]:
    """Return which pieces without a joint between them would stick together in a print."""
    names, roots = link_names(model), _roots(model)
    solids = dict(zip(roots, _joined(model, printer, 0), strict=True))
    found = []
    for place, first in enumerate(roots):
        for second in roots[place + 1 :]:
            if _neighbours(model, first, second):
                continue
            apart = solids[first].min_gap(solids[second], printer.gap)
            if 0 < apart < printer.gap:
                found.append(
                    f"{names[first]} and {names[second]} are {apart:.2f} mm apart, and a gap needs "
                    f"{printer.gap:g} mm"
                )
    return tuple(found)


def _neighbours(model: mujoco.MjModel, first: int, second: int) -> bool:
    """Return whether a joint connects two pieces."""
    above = [int(model.body_weldid[model.body_parentid[piece]]) for piece in (first, second)]
    return above[0] == second or above[1] == first
