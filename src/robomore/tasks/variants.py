"""Tasks of the paper's side studies: Ant with weaker motors, and on other terrains.

They are known by their ids like any other, but are no tasks of the paper's main comparison, and
`robomore tasks` does not list them.
"""

from __future__ import annotations

from dataclasses import replace

from robomore.tasks.ant import ANT, ANT_DESERT, ANT_POWERED
from robomore.tasks.task import Task, Terrain
from robomore.tasks.terrain import GROUND, HILLS, SNOW, on_terrain

GEARS = (50, 100, 150, 200, 250)
"""Gears beside Ant-Powered's own 300 (paper, "Robustness across Different Gear Powers")."""


def _powered(gear: int) -> Task:
    return replace(
        ANT_POWERED,
        id=f"ant-powered-{gear}",
        title=f"Ant-Powered, gear {gear}",
        description=f"{ANT.description} Its motors have a gear of {gear}.",
        constants={"gear": float(gear)},
    )


def _on(name: str, terrain: Terrain, ground: str) -> Task:
    return replace(
        ANT_DESERT,
        id=f"ant-{name}",
        title=f"Ant-{name.title()}",
        description=f"{ANT.description} The ground is {ground}.",
        template=on_terrain(ANT.template, terrain),
        terrain=terrain,
    )


VARIANTS: dict[str, Task] = {
    task.id: task
    for task in (
        *map(_powered, GEARS),
        _on("ground", GROUND, "flat"),
        _on("snow", SNOW, "covered with snow: it is uneven, with very little friction"),
        _on("hills", HILLS, "hilly and firm"),
    )
}
"""By id."""
