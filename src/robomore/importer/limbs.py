"""Finds the limbs of a robot: its links, where each begins and ends, and which ones repeat."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_SIDES = frozenset("left right l r fl fr rl rr hl hr bl br lf rf lh rh lb rb".split()) | frozenset(  # noqa: SIM905
    "front back hind rear fore mid middle link body joint geom collision".split()  # noqa: SIM905
)
"""Words of a name that say where a part is, or that it is one, and not what it is."""

_SAME = 0.02
"""Relative difference in length, thickness and mass below which links repeat each other."""

_SHORTEST = 0.01
"""Length in m below which a link is a joint's housing rather than a limb."""

_STRAIGHT = 0.9
"""Cosine above which a link counts as lying along an axis of its frame."""

ROUND = (int(mujoco.mjtGeom.mjGEOM_CAPSULE), int(mujoco.mjtGeom.mjGEOM_CYLINDER))
"""Geoms with two ends."""

_TURNING = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_BALL))
"""Types of joints that have an anchor."""


@dataclass(frozen=True, slots=True)
class Link:
    """A moving part of a robot. Vectors are in the link's own frame.

    Attributes:
        name: of the body.
        body: its number in the model.
        depth: joints' bodies between the root and here; the root has 0.
        begin: where it hangs, in m: the anchor of its joint.
        axis: unit vector from where the link begins to where it ends.
        length: distance between these two points, in m; 0 if it is no limb.
        radius: half of its thickness across `axis`, in m; 0 if nothing in it has one.
        mass: in kg.
        leaf: whether nothing is attached to it.
    """

    name: str
    body: int
    depth: int
    begin: tuple[float, float, float]
    axis: tuple[float, float, float]
    length: float
    radius: float
    mass: float
    leaf: bool

    @property
    def end(self) -> Array:
        """Where the next link hangs, or where the limb ends, (3,) in m."""
        return np.array(self.begin) + np.array(self.axis) * self.length


def find_links(model: mujoco.MjModel) -> dict[str, Link]:
    """Return the links of the robot by name, the root first."""
    return {link.name: link for body in range(1, model.nbody) for link in [_link(model, body)]}


def groups(links: dict[str, Link], model: mujoco.MjModel) -> list[tuple[str, tuple[Link, ...]]]:
    """Return links that repeat each other, mirrored or not, under a name for what they are.

    Links repeat each other if they have the same length, thickness and mass, and their parents do,
    or if their names differ in the side alone. The root is left out.
    """
    found: list[list[Link]] = []
    group_of = {link.name: -1 for link in links.values() if link.depth == 0}
    for link in links.values():
        if link.depth == 0:
            continue
        parent = model.body(int(model.body_parentid[link.body])).name
        for number, group in enumerate(found):
            other = group[0]
            above = model.body(int(model.body_parentid[other.body])).name
            alike = _alike(link, other) and group_of.get(parent) == group_of.get(above)
            named = kind(link.name) == kind(other.name) and _alike(link, other, 5 * _SAME)
            if link.depth == other.depth and (alike or named):
                group.append(link)
                group_of[link.name] = number
                break
        else:
            group_of[link.name] = len(found)
            found.append([link])
    taken: set[str] = set()
    named_groups = []
    for group in found:
        name = _common(group)
        if name in taken:
            name = re.sub(r"\W|_?link$", "", group[0].name.lower())
        taken.add(name)
        named_groups.append((name, tuple(group)))
    return named_groups


def kind(name: str) -> str:
    """Return a part's name without its side: `FL_thigh` and `thigh_back_right` are `thigh`."""
    spaced = re.sub(r"([a-z])([A-Z])", r"\1_\2", name)
    words = [word for word in re.split(r"[\W_]+", spaced.lower()) if word]
    kept = [word for word in words if word not in _SIDES and not word.isdigit()]
    return "_".join(kept) or "_".join(words) or "part"


def anchor(model: mujoco.MjModel, body: int) -> Array:
    """Return the point (3,) of a body around which its first hinge turns it, in m in its frame."""
    first = int(model.body_jntadr[body])
    for joint in range(first, first + int(model.body_jntnum[body])):
        if int(model.jnt_type[joint]) in _TURNING:
            return np.array(model.jnt_pos[joint])
    return np.zeros(3)


def ends(model: mujoco.MjModel, geom: int) -> Array:
    """Return both ends (2, 3) of a capsule or cylinder in its body's frame, in m."""
    along = rotation(model.geom_quat[geom])[:, 2] * model.geom_size[geom, 1]
    return np.stack((model.geom_pos[geom] + along, model.geom_pos[geom] - along))


def rotation(quaternion: Array) -> Array:
    """Return the matrix (3, 3) of a quaternion w, x, y, z."""
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, np.asarray(quaternion, dtype=float))
    return matrix.reshape(3, 3)


def geoms_of(model: mujoco.MjModel, body: int) -> range:
    """Return the numbers of a body's geoms."""
    first = int(model.body_geomadr[body])
    return range(first, first + int(model.body_geomnum[body])) if first >= 0 else range(0)


def _link(model: mujoco.MjModel, body: int) -> Link:
    children = [b for b in range(1, model.nbody) if model.body_parentid[b] == body]
    depth, above = 0, body
    while model.body_parentid[above]:
        above = int(model.body_parentid[above])
        depth += 1
    begin = end = anchor(model, body)
    if children:
        # The child that carries most continues the limb.
        next_one = max(children, key=lambda b: float(model.body_subtreemass[b]))
        turned = rotation(model.body_quat[next_one])
        end = model.body_pos[next_one] + turned @ anchor(model, next_one)
    else:
        points = [point for geom in geoms_of(model, body) for point in _far_points(model, geom)]
        end = max(points, key=lambda p: float(np.linalg.norm(p - begin)), default=end)
    end = end - begin
    largest = int(np.argmax(np.abs(end)))
    if abs(end[largest]) > _STRAIGHT * np.linalg.norm(end):
        # What stands aside is an offset of the joint, which a longer link keeps.
        end = np.where(np.arange(3) == largest, end, 0.0)
    length = float(np.linalg.norm(end))
    axis = end / length if length > _SHORTEST else np.array([0.0, 0.0, 1.0])
    return Link(
        name=model.body(body).name,
        body=body,
        depth=depth,
        begin=tuple(begin.tolist()),
        axis=tuple(axis.tolist()),
        length=length if length > _SHORTEST else 0.0,
        radius=_radius(model, body, axis),
        mass=float(model.body_mass[body]),
        leaf=not children,
    )


def _far_points(model: mujoco.MjModel, geom: int) -> Array:
    """Return points (n, 3) at which a limb that ends in this geom may end."""
    if int(model.geom_type[geom]) in ROUND:
        return ends(model, geom)
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_SPHERE:
        return np.array(model.geom_pos[geom])[None]
    half = model.geom_aabb[geom, 3:]
    longest = int(np.argmax(half))
    along = rotation(model.geom_quat[geom])[:, longest] * half[longest]
    return np.stack((model.geom_pos[geom] + along, model.geom_pos[geom] - along))


def _radius(model: mujoco.MjModel, body: int, axis: Array) -> float:
    """Return the median half thickness across `axis` of what lies along it, in m."""
    radii = []
    for geom in geoms_of(model, body):
        turned = np.abs(rotation(model.geom_quat[geom]).T @ axis)
        if int(model.geom_type[geom]) in ROUND:
            if turned[2] > 0.7:
                radii.append(float(model.geom_size[geom, 0]))
        elif model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_SPHERE:
            across = np.delete(model.geom_aabb[geom, 3:], int(np.argmax(turned)))
            radii.append(float(np.sqrt(across.prod())))
    if not radii:
        radii = [float(model.geom_size[geom, 0]) for geom in geoms_of(model, body)]
    return float(np.median(radii)) if radii else 0.0


def _alike(one: Link, other: Link, tolerance: float = _SAME) -> bool:
    pairs = ((one.length, other.length), (one.radius, other.radius), (one.mass, other.mass))
    return one.leaf == other.leaf and all(
        abs(a - b) <= tolerance * max(abs(a), abs(b)) + 1e-9 for a, b in pairs
    )


def _common(group: Sequence[Link]) -> str:
    """Return the name that says what a group's links are."""
    kinds = [kind(link.name) for link in group]
    name = max(kinds, key=kinds.count)
    return name if name.isidentifier() else f"part_{name}"
