"""The ends of a robot's limbs: what stands on the ground, and what touches things."""

from __future__ import annotations

import mujoco

from robomore.importer.limbs import find_links, geoms_of


def contact_names(model: mujoco.MjModel) -> dict[str, str]:
    """Return the last link of each limb by the name under which its contacts are told.

    That is the name of the solid at its end, if it has one of its own (`FL_foot_collision` is told
    as `FL_foot`), and else the link's.
    """
    names: dict[str, str] = {}
    for link in find_links(model).values():
        geoms = [g for g in geoms_of(model, link.body) if _touches(model, g)]
        if not (link.leaf and link.depth and geoms):
            continue
        last = max(geoms, key=lambda geom: float((model.geom_pos[geom] ** 2).sum()))
        name = model.geom(last).name
        for ending in ("_collision", "_geom", "_link"):
            name = name.removesuffix(ending)
        names[name if name not in names else link.name] = link.name
    return names


def _touches(model: mujoco.MjModel, geom: int) -> bool:
    return bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
