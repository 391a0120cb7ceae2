"""`robomore tasks` and `robomore inspect`: what there is to do, and one robot, untrained."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar

from cyclopts import Parameter

from robomore.cli.completion import TASK
from robomore.cli.inputs import read_parameters
from robomore.cli.output import write, write_json

if TYPE_CHECKING:
    from robomore.tasks import Task

T = TypeVar("T")

_log = logging.getLogger(__name__)

_COLUMNS = 72
"""Width of the picture in the terminal, in characters."""


def tasks(*, as_json: Annotated[bool, Parameter("--json", negative="")] = False) -> None:
    """List the tasks.

    Parameters
    ----------
    as_json
        Print JSON: parameters with bounds, units and meaning, rules, volumes.
    """
    from robomore.tasks import TASKS

    found = [task for _, task in TASKS.items()]
    if as_json:
        write_json([data for data in map(_as_data, found) if data])
        return
    lines = [f"{'task':14} {'parameters':>10}  {'volume':>13}  to do"]
    lines += [line for line in map(_line, found) if line]
    lines.append("")
    lines.append("`robomore inspect TASK` shows a robot, `robomore run TASK` improves it.")
    write("\n".join(lines) + "\n")


def inspect(
    task: Annotated[str, TASK],
    /,
    *,
    parameters: str = "reference",
    mjcf: Literal["filled", "masked"] | None = None,
    picture: Path | None = None,
    as_json: Annotated[bool, Parameter("--json", negative="")] = False,
) -> None:
    """Show one morphology: its volume, its mass, its height at rest, and a picture.

    Parameters
    ----------
    task
        Id of a task (`robomore tasks` lists them), or the path of a task file (.toml).
    parameters
        `reference`, or a JSON file: a list in the task's order, or an object by name.
    mjcf
        Print the robot's MJCF text and nothing else: `filled` with these parameters, or `masked`
        as a designer sees it.
    picture
        Draw the robot into this file (.svg or .png).
    as_json
        Print JSON, the two MJCF texts in it.
    """
    from robomore.tasks import get_task

    chosen = get_task(task)
    values = read_parameters(chosen, parameters)
    if mjcf is not None:
        text = chosen.masked_mjcf if mjcf == "masked" else chosen.mjcf(values)
        write(text.rstrip() + "\n")
        return

    from robomore.envs.compile import body_facts
    from robomore.envs.union import union_volume
    from robomore.rendering.drawing import draw
    from robomore.rendering.pictures import save_picture

    facts = body_facts(chosen, values)
    union = union_volume(chosen, values)
    if picture is not None:
        save_picture(draw(chosen, values), picture, chosen.title)
    if as_json:
        write_json(
            {
                "task": chosen.id,
                "parameters": chosen.named(values),
                **facts,
                "union_volume": union,
                "picture": str(picture) if picture else None,
                "mjcf": chosen.mjcf(values),
                "masked_mjcf": chosen.masked_mjcf,
            }
        )
        return
    _print_morphology(chosen, values, facts, union)
    if picture is not None:
        write(f"picture: {picture}\n")


def _unless_broken(told: Callable[[Task], T]) -> Callable[[Task], T | None]:
    """Return what is told of a task, or `None` and a warning where the task itself is broken."""

    def safe(task: Task) -> T | None:
        try:
            return told(task)
        except Exception as error:  # noqa: BLE001  # a task is code of somebody's package
            said = f"{type(error).__name__}: {error}"
            _log.warning(
                "the task %s is broken (%s); mend its package. Everything else still works",
                task.id,
                said,
            )
            return None

    return safe


@_unless_broken
def _line(task: Task) -> str:
    goal = {"distance": "run far", "height": "jump high"}.get(task.goal.name, task.goal.name)
    volume = task.volume(task.reference)
    return f"{task.id:14} {len(task.parameters):10}  {volume:10.6f} m³  {goal}"


@_unless_broken
def _as_data(task: Task) -> dict[str, Any]:
    return {
        "id": task.id,
        "version": task.version,
        "title": task.title,
        "description": task.description,
        "fitness": task.goal.name,
        "fitness_meaning": task.goal.meaning,
        "fitness_unit": task.goal.unit,
        "volume": task.volume(task.reference),
        "parameters": [
            {
                "name": parameter.name,
                "low": parameter.low,
                "high": parameter.high,
                "search": parameter.search or (parameter.low, parameter.high),
                "reference": parameter.reference,
                "unit": parameter.unit,
                "scale": parameter.scale,
                "meaning": parameter.meaning,
            }
            for parameter in task.parameters
        ],
        "rules": [rule.text for rule in task.rules],
        "search_rules": [rule.text for rule in task.search_rules],
        "reward": task.reward,
    }


def _print_morphology(
    task: Task, values: tuple[float, ...], facts: dict[str, float], union: float | None
) -> None:
    from rich.table import Table
    from rich.text import Text

    from robomore.cli.output import console
    from robomore.runs.words import number

    screen = console()
    screen.print(Text.assemble((task.title, "bold"), f"  {task.description}\n"))
    if screen.is_terminal:
        _print_picture(task, values)
    table = Table(box=None, pad_edge=False)
    for heading, side in (("parameter", "left"), ("value", "right"), ("reference", "right")):
        table.add_column(heading, justify="right" if side == "right" else "left")
    table.add_column("bounds")
    table.add_column("meaning")
    for parameter, value in zip(task.parameters, values, strict=True):
        table.add_row(
            parameter.name,
            f"{value:g} {parameter.unit}",
            f"{parameter.reference:g}",
            f"{parameter.low:g} … {parameter.high:g}",
            parameter.meaning,
        )
    screen.print(table)
    once = f"; overlaps counted once {union:.6f} m³" if union is not None else ""
    screen.print(
        f"\nvolume       {facts['volume']:.6f} m³{once}\n"
        f"mass         {number(facts['mass'])} kg\n"
        f"density      {number(facts['density'])} kg/m³ (mass divided by volume)\n"
        f"rest height  {number(facts['rest_height'])} m"
        + (f"\nmass by      {task.mass}" if task.mass else "")
    )


def _print_picture(task: Task, values: tuple[float, ...]) -> None:
    """Draw the robot with half blocks: two pixels in each character."""
    import numpy as np
    from rich.color import Color
    from rich.segment import Segment, Segments
    from rich.style import Style

    from robomore.cli.output import console
    from robomore.rendering.drawing import draw
    from robomore.rendering.pictures import frame_around, image

    scene = draw(task, values)
    rgb = np.asarray(image(scene, frame_around(scene, _COLUMNS, _COLUMNS // 2), smooth=4))
    segments = []
    for upper, lower in zip(rgb[::2].tolist(), rgb[1::2].tolist(), strict=True):
        for above, below in zip(upper, lower, strict=True):
            style = Style(color=Color.from_rgb(*above), bgcolor=Color.from_rgb(*below))
            segments.append(Segment("▀", style))
        segments.append(Segment.line())
    console().print(Segments(segments))
