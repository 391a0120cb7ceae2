"""What ties links together beside their joints, closed chains and tendons, as lengths change."""

from __future__ import annotations

import itertools
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from robomore.errors import InputError
from robomore.importer.amounts import Amount, texts
from robomore.tasks.task import Parameter
from robomore.tasks.template import fill

_TOLERANCE = 1e-3
"""Length in m by which a loop may open, or a tendon leave its range, as lengths change."""

_TIES = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))

Moved = Callable[[str, Any], Sequence[Amount | float]]


def move_anchors(root: ET.Element, model: mujoco.MjModel, moved: Moved) -> None:
    """Write the two points that an equality ties together as sites, which move with their links.

    MuJoCo would find the second point anew from the first one, wherever that has come to lie.

    Args:
        root: the template, with its bodies written. Its equalities are edited.
        model: of the robot as it was read.
        moved: returns where a point (3,) of a body, by name, is once the body is stretched.
    """
    places = (part for part in root.iter() if part.tag in ("worldbody", "body"))
    bodies = {part.get("name", "world"): part for part in places}
    for number, element in enumerate(root.iterfind("equality/*")):
        if element.tag not in ("connect", "weld") or element.get("site1"):
            continue
        data = model.eq_data[number]
        points, turn = (data[:3], data[3:6]), {}
        if element.tag == "weld":
            points, turn = (data[3:6], data[:3]), {"quat": texts(data[6:10])}
        ends = (model.eq_obj1id[number], model.eq_obj2id[number])
        for name in ("body1", "body2", "anchor", "relpose"):
            element.attrib.pop(name, None)
        for which, (end, point) in enumerate(zip(ends, points, strict=True), start=1):
            name = model.body(int(end)).name
            site = f"{element.get('name') or f'equality_{number}'}_{which}"
            place = {"name": site, "pos": texts(moved(name, point))}
            place |= turn if which == 1 else {}
            ET.SubElement(bodies[name], "site", place)
            element.set(f"site{which}", site)


def free_springs(root: ET.Element, model: mujoco.MjModel) -> None:
    """Leave out of a template at which length a tendon rests, where that is its length in the file.

    MuJoCo writes it as a number, and computes it anew where there is none.
    """
    for number, tendon in enumerate(root.iterfind("tendon/*")):
        rests = np.array(tendon.get("springlength", "nan").split(), dtype=float)
        if tendon.tag == "spatial" and np.allclose(rests, model.tendon_length0[number], rtol=1e-4):
            del tendon.attrib["springlength"]


def refuse_strain(
    id: str,
    template: str,
    parameters: Sequence[Parameter],
    assets: Mapping[str, bytes],
    rest: Callable[[mujoco.MjModel], Any],
) -> None:
    """Refuse lengths that open a closed chain at rest, or that a tendon's range does not allow.

    Args:
        id: of the task, for the message.
        template: with placeholders.
        parameters: of the task; the bounds of lengths are tried, one by one and all at once.
        assets: content of the meshes by name.
        rest: returns qpos (nq,) at rest.

    Raises:
        InputError: naming the parameter, its value, the loop or tendon and by how much.
    """

    def strains(values: Mapping[str, float]) -> dict[str, float]:
        spec = mujoco.MjSpec.from_string(fill(template, values), assets=dict(assets))
        model = spec.compile()
        return _strains(model, rest(model))

    reference = {one.name: one.reference for one in parameters}
    if not (before := strains(reference)):
        return
    lengths = [one for one in parameters if one.unit == "m"]
    bounds = [{one.name: value} for one in lengths for value in (one.low, one.high)]
    bounds += [{one.name: getattr(one, end) for one in lengths} for end in ("low", "high")]
    for changed in bounds:
        for what, strain in strains(reference | changed).items():
            if strain > before[what] + _TOLERANCE:
                values = ", ".join(f"{name} = {value:g} m" for name, value in changed.items())
                raise InputError(
                    f"{id}: with {values} {what} by {strain:.2g} m at rest. Let one parameter "
                    "change all links that have to fit together (`of`), narrow its bounds, leave "
                    "it out, or widen a tendon's range in the robot's file"
                )


def tied(model: mujoco.MjModel) -> frozenset[int]:
    """Return the bodies by number whose length decides whether a closed chain closes, or how long
    a limited tendon is."""
    pairs = []
    for number in np.flatnonzero(np.isin(model.eq_type, _TIES)):
        pair = [model.eq_obj1id[number], model.eq_obj2id[number]]
        on_sites = model.eq_objtype[number] == mujoco.mjtObj.mjOBJ_SITE
        pairs.append(model.site_bodyid[pair] if on_sites else pair)
    for tendon in np.flatnonzero(model.tendon_limited):
        first, count = model.tendon_adr[tendon], model.tendon_num[tendon]
        wraps = range(first, first + count)
        sites = [one for one in wraps if model.wrap_type[one] == mujoco.mjtWrap.mjWRAP_SITE]
        bodies = model.site_bodyid[model.wrap_objid[sites]]
        pairs += itertools.pairwise(bodies)
    found: set[int] = set()
    for one, other in pairs:
        above, beside = _upwards(model, int(one)), _upwards(model, int(other))
        found |= set(above) ^ set(beside)
        found.add(next(body for body in above if body in beside))  # where both hang
    return frozenset(found)


def _upwards(model: mujoco.MjModel, body: int) -> list[int]:
    """Return a body and all above it, the world last."""
    found = [body]
    while found[-1]:
        found.append(int(model.body_parentid[found[-1]]))
    return found


def _strains(model: mujoco.MjModel, qpos: Any) -> dict[str, float]:
    """Return by how many m each loop is open and each limited tendon outside of its range."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    found: dict[str, float] = {}
    for number in range(model.neq):
        if model.eq_objtype[number] == mujoco.mjtObj.mjOBJ_SITE and model.eq_active0[number]:
            ends = data.site_xpos[[model.eq_obj1id[number], model.eq_obj2id[number]]]
            name = model.equality(number).name or f"equality {number}"
            found[f"the loop `{name}` is open"] = float(np.linalg.norm(ends[1] - ends[0]))
    for number in range(model.ntendon):
        joints = model.wrap_type[model.tendon_adr[number]] == mujoco.mjtWrap.mjWRAP_JOINT
        if model.tendon_limited[number] and not joints:
            low, high = model.tendon_range[number]
            length = float(data.ten_length[number])
            name = model.tendon(number).name or f"tendon {number}"
            found[f"the tendon `{name}` is outside of its range"] = max(
                length - high, low - length, 0.0
            )
    return found
