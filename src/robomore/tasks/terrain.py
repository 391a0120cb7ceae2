"""The paper's terrains as values, and how a template's flat floor becomes one of them.

The elevations themselves are made where something is simulated (`robomore.envs.terrain`).
"""

from __future__ import annotations

import re

from robomore.tasks.task import Terrain

TILE = 64.0
"""Side of a tile, in m."""

CELLS = 128
"""Cells along a tile's side: one elevation every half metre."""

BEHIND, AHEAD, ASIDE = 1, 12, 2
"""Tiles beyond the first in each direction: ahead, 50 s at 15 m/s. Beyond them it is flat."""

MEAN, DEVIATION = 120 / 255, 46 / 255
"""Of the paper's elevation pictures, as fractions of the highest elevation."""

DESERT = Terrain(
    seed=1, height=1.5, half_correlation=4.6, slope=0.077,
    mean=MEAN, deviation=DEVIATION, friction=0.4,
)  # fmt: skip
SNOW = Terrain(
    seed=2, height=1.5, half_correlation=3.4, slope=0.096,
    mean=MEAN, deviation=DEVIATION, friction=0.3,
)  # fmt: skip
HILLS = Terrain(
    seed=3, height=1.5, half_correlation=2.3, slope=0.156,
    mean=MEAN, deviation=DEVIATION, friction=1.0,
)  # fmt: skip
GROUND = Terrain(
    seed=0, height=0.0, half_correlation=TILE, slope=0.0, mean=0.0, deviation=0.0, friction=1.0
)
"""Flat: a plane with the terrain's friction."""

_FLOOR = re.compile(r'( *)<geom name="floor"[^>]*/>\n')


def on_terrain(template: str, terrain: Terrain) -> str:
    """Return an MJCF template whose flat floor is replaced by `terrain`.

    MuJoCo takes the larger friction of two touching geoms unless one has priority, so the ground
    has it. The elevations are no part of the text: `robomore.envs.compile` fills them in.

    Raises:
        ValueError: the template has no geom named `floor`.
    """
    floor = _FLOOR.search(template)
    if floor is None:
        raise ValueError('a template needs <geom name="floor" .../> to be put on a terrain')
    surface = (
        f'conaffinity="1" priority="1" friction="{terrain.friction!r} 0.5 0.5" material="ground"'
    )
    if not terrain.height:
        plane = f'<geom name="floor" type="plane" size="40 40 40" {surface}/>'
        return template.replace(floor[0], f"{floor[1]}{plane}\n")
    corner = f"{-BEHIND * TILE:g} {-ASIDE * TILE:g} 0"
    lines = (
        "<!-- Tiles of noise; the plane below them goes on where they end. -->",
        f'<geom name="floor" type="plane" pos="0 0 -0.05" size="40 40 40" {surface}/>',
        f'<frame pos="{corner}">',
        f'  <replicate count="{BEHIND + 1 + AHEAD}" offset="{TILE:g} 0 0" sep="_">',
        f'    <replicate count="{2 * ASIDE + 1}" offset="0 {TILE:g} 0" sep="_">',
        f'      <geom name="tile" type="hfield" hfield="noise" {surface}/>',
        "    </replicate>",
        "  </replicate>",
        "</frame>",
    )
    # Solid for a metre below zero, so that nothing fast and thin falls through.
    asset = (
        f'    <hfield name="noise" nrow="{CELLS + 1}" ncol="{CELLS + 1}" '
        f'size="{TILE / 2:g} {TILE / 2:g} {terrain.height!r} 1"/>\n'
    )
    tiles = "".join(f"{floor[1]}{line}\n" for line in lines)
    return template.replace(floor[0], tiles).replace("  </asset>\n", f"{asset}  </asset>\n")
