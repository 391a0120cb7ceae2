"""A robot drawn without OpenGL: its solids projected along parallel rays.

A capsule seen along parallel rays is exactly a thick line with round ends, a ball a disc, a box up
to three sides, and any other convex solid its outline. So a handful of strokes, far ones first, is
a true picture. It needs no graphics driver, which is what
servers and reports lack. `robomore.rendering.pictures` turns a `Scene` into SVG or pixels.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.compile import Parameters, compile_model
from robomore.envs.rest_pose import starting_pose
from robomore.envs.terrain import tile
from robomore.rendering.outlines import Face, View, solids
from robomore.tasks.portable import FixedOptions
from robomore.tasks.task import Task, Terrain
from robomore.tasks.terrain import CELLS, TILE

Array = NDArray[np.float64]
Height = Callable[[Array, Array], Array]
"""Elevation of the ground in m at x, y in m."""

PALETTE = ("#d9822b", "#3f7fbf", "#4a9e6b", "#8a63b5", "#c2554d", "#6b7f8c")
"""The torso first, then by distance from it in the kinematic tree."""


@dataclass(frozen=True, slots=True)
class Stroke:
    """One solid in the picture, in m: a thick line with round ends (a disc if both ends agree).

    Of a solid that is no capsule, the line is the capsule that comes closest, and is not drawn.

    Attributes:
        start: (2,) to the right and up.
        end: (2,) likewise.
        radius: half of the thickness.
        depth: of its middle; larger is nearer.
        colour: as `#rrggbb`.
        geom: number of the solid in the model.
        faces: what is drawn of a solid that is no capsule.
    """

    start: Array
    end: Array
    radius: float
    depth: float
    colour: str
    geom: int
    faces: tuple[Face, ...] = ()

    @property
    def corners(self) -> Array:
        """Points (n, 2) between whose extremes the solid lies, in m."""
        if self.faces:
            return np.concatenate([face.corners for face in self.faces])
        ends = np.stack((self.start, self.end))
        return np.concatenate((ends - self.radius, ends + self.radius))


@dataclass(frozen=True, slots=True)
class Mark:
    """A remark on some solids.

    Attributes:
        places: (2,) to the right and up, in m.
        text: the remark.
    """

    places: tuple[Array, ...]
    text: str


@dataclass(frozen=True, slots=True)
class Scene:
    """A robot in one pose, projected. All lengths in m.

    Attributes:
        strokes: far ones first.
        ground: lines on the ground, each (points, 2).
        low: (2,) left lower corner of all strokes.
        high: (2,) right upper corner.
        marks: remarks, which are numbered in their order.
    """

    strokes: tuple[Stroke, ...]
    ground: tuple[Array, ...]
    low: Array
    high: Array
    marks: tuple[Mark, ...] = ()


def draw(task: Task, parameters: Parameters) -> Scene:
    """Return the picture of a robot at rest, on flat ground.

    Raises:
        InvalidMorphology: the task refuses the parameters, or MuJoCo the model.
    """
    model = compile_model(task, parameters)
    data = mujoco.MjData(model)
    data.qpos[:] = picture_pose(task, model)
    mujoco.mj_kinematics(model, data)
    view = view_of(model)
    bare = project(model, data, view)
    size = float(max(bare.high - bare.low))
    ground = ground_lines(view, data.subtree_com[1], 0.6 * size, nice_length(size / 5))
    return project(model, data, view, ground)


def view_of(model: mujoco.MjModel) -> View:
    """Return the side from which a robot shows most: along its hinges, else from front above."""
    free = (model.jnt_type == mujoco.mjtJoint.mjJNT_FREE).any()
    hinges = model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE
    if free or not hinges.any():
        return _looking_from(azimuth=-65.0, elevation=24.0)
    axis = np.abs(model.jnt_axis[hinges]).mean(axis=0)
    return _looking_from(azimuth=-90.0, elevation=90.0 if axis[2] > axis[1] else 0.0)


def picture_pose(task: Task, model: mujoco.MjModel) -> Array:
    """Return joint positions (nq,) for a picture of a task's robot."""
    from_file = isinstance(task.options, FixedOptions)
    return starting_pose(task, model) if from_file else rest_pose(model)


def rest_pose(model: mujoco.MjModel) -> Array:
    """Return joint positions (nq,) for a picture: as compiled, but every joint within its range.

    A joint whose range leaves out its zero (the Ant's ankles) stands in the middle of the range,
    and a robot that moves freely is lowered until it touches the ground at height 0.
    """
    qpos: Array = model.qpos0.copy()
    for joint in range(model.njnt):
        low, high = model.jnt_range[joint]
        address = model.jnt_qposadr[joint]
        if model.jnt_limited[joint] and not low <= qpos[address] <= high:
            qpos[address] = (low + high) / 2
    if model.njnt and model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE:
        data = mujoco.MjData(model)
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        qpos[2] -= min(one.lowest for one in solids(model, data))
    return qpos


def project(
    model: mujoco.MjModel, data: mujoco.MjData, view: View, ground: tuple[Array, ...] = ()
) -> Scene:
    """Return the picture of a robot in the pose that `data` holds.

    Args:
        model: of the robot.
        data: after `mj_kinematics` or a step.
        view: where one looks from.
        ground: lines on the ground.
    """
    strokes = []
    for one in solids(model, data):
        middle = (one.start + one.end) / 2
        start, end = view.flat(one.start), view.flat(one.end)
        colour = PALETTE[min(distance_to_world(model, one.body), len(PALETTE)) - 1]
        depth = float(middle @ view.towards)
        faces = one.faces(view)
        strokes.append(Stroke(start, end, one.radius, depth, colour, one.geom, faces))
    corners = np.concatenate([stroke.corners for stroke in strokes])
    return Scene(
        strokes=tuple(sorted(strokes, key=lambda stroke: stroke.depth)),
        ground=ground,
        low=np.min(corners, axis=0),
        high=np.max(corners, axis=0),
    )


def ground_lines(
    view: View, around: Array, reach: float, spacing: float, height: Height | None = None
) -> tuple[Array, ...]:
    """Return lines on the ground, so that size and motion can be seen.

    From the side: the ground's profile, with a tick below it at every multiple of `spacing`; else
    a grid of that spacing.

    Args:
        view: where one looks from.
        around: (3,) point that the lines surround.
        reach: how far they go, in m.
        spacing: of ticks and grid, in m.
        height: elevation of the ground; flat at 0 without one.
    """

    def flat(x: Array, y: Array) -> Array:
        z = height(x, y) if height else np.zeros_like(x)
        return view.flat(np.stack((x, y, z), axis=-1))

    x, y = float(around[0]), float(around[1])
    if abs(view.towards[2]) < 1e-9:
        along = np.linspace(x - reach, x + reach, 129)
        profile = flat(along, np.full_like(along, y))
        ticks = [flat(at, np.full(1, y))[0] for at in _multiples(x, reach, spacing)]
        fall = np.array([0.0, -spacing / 8])
        return (profile, *(np.stack((tick, tick + fall)) for tick in ticks))
    lines = []
    for at in _multiples(x, reach, spacing):
        half = math.sqrt(max(0.0, reach**2 - (float(at[0]) - x) ** 2))
        along = np.linspace(y - half, y + half, 33)
        lines.append(flat(np.full_like(along, at[0]), along))
    for at in _multiples(y, reach, spacing):
        half = math.sqrt(max(0.0, reach**2 - (float(at[0]) - y) ** 2))
        along = np.linspace(x - half, x + half, 33)
        lines.append(flat(along, np.full_like(along, at[0])))
    return tuple(lines)


def elevation(terrain: Terrain) -> Height:
    """Return the elevation of a generated ground as a function, between its grid points too."""
    heights = tile(terrain) * terrain.height

    def at(x: Array, y: Array) -> Array:
        column, row = (((v + TILE / 2) * CELLS / TILE) % CELLS for v in (x, y))
        j, i = column.astype(int), row.astype(int)
        s, t = column - j, row - i
        near = (1 - s) * heights[i, j] + s * heights[i, j + 1]
        far = (1 - s) * heights[i + 1, j] + s * heights[i + 1, j + 1]
        return np.asarray((1 - t) * near + t * far)

    return at


def nice_length(most: float) -> float:
    """Return the longest of 1, 2, 5, 10, … (and their tenths) that is no longer than `most`."""
    power = 10.0 ** math.floor(math.log10(most))
    return next(step * power for step in (5.0, 2.0, 1.0) if step * power <= most * (1 + 1e-9))


def distance_to_world(model: mujoco.MjModel, body: int) -> int:
    """Return how many bodies stand between `body` and the world, itself included."""
    steps = 0
    while body:
        body = int(model.body_parentid[body])
        steps += 1
    return steps


def _multiples(middle: float, reach: float, spacing: float) -> list[Array]:
    first, last = math.ceil((middle - reach) / spacing), math.floor((middle + reach) / spacing)
    return [np.array([index * spacing]) for index in range(first, last + 1)]


def _looking_from(azimuth: float, elevation: float) -> View:
    """Return the view from a direction: degrees from +x about z, and above the horizon."""
    a, e = math.radians(azimuth), math.radians(elevation)
    towards = np.array([math.cos(a) * math.cos(e), math.sin(a) * math.cos(e), math.sin(e)])
    right = np.array([-math.sin(a), math.cos(a), 0.0])
    return View(right.round(12), np.cross(towards, right).round(12), towards.round(12))
