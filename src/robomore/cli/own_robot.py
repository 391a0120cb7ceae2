"""`robomore new` and `robomore check-task`: a robot of one's own, from its file to a task."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from robomore.cli.completion import TASK
from robomore.cli.inputs import new_folder
from robomore.cli.output import write

if TYPE_CHECKING:
    import mujoco

    from robomore.importer.task_file import ReadTask
    from robomore.tasks import Task


_OBJECTIVES = {"transport-economy": "transport-economy", "target-reached": "fitness"}
"""What a search compares for a goal of which a quotient by the robot's volume says little."""


_UNNAMED = "MuJoCo Model"
"""What MuJoCo calls a model whose file gives it no name."""


def new(
    robot: Path,
    /,
    *,
    free: Annotated[list[str] | None, Parameter(negative="")] = None,
    goal: Literal["distance", "economy"] | None = None,
    base: Literal["free", "fixed"] | None = None,
    name: str | None = None,
    out: Path | None = None,
) -> None:
    """Make a task from a robot's MJCF or URDF file: a small text file to be edited.

    Parameters
    ----------
    robot
        An MJCF file (.xml) or a URDF file (.urdf).
    free
        What is to be free, as a name or a pattern (`thigh`, `*_length`, `calf_strength`); may be
        given several times. By default the length and thickness of the longest links.
    goal
        To get far (`distance`, the default), or with little energy (`economy`: 1 / cost of
        transport). For a robot that moves freely; a fixed one reaches for a target.
    base
        Whether the robot moves freely or is fixed to the world. By default as an MJCF file says; a
        URDF file does not say it, and its robot moves freely.
    name
        What the task is called. By default as the robot's file, without its ending.
    out
        New folder for the task file, the robot and its meshes; by default called as the task.
    """
    from robomore.importer.proposal import identifier, write_proposal
    from robomore.importer.reading import read_robot
    from robomore.importer.rest import home_notes
    from robomore.importer.task_file import read_task_file

    read = read_robot(robot, base)
    folder = out or Path(identifier(name) if name else robot.stem)
    new_folder(folder)
    file = write_proposal(read, robot, folder, free or (), goal, name)
    made = read_task_file(file)
    inside = read.spec().modelname
    called = (
        f"the task is called as the file, which calls the robot {inside!r}; give --name for another"
    )
    alike = name or identifier(inside) in (identifier(_UNNAMED), made.task.id)
    _tell(made, (*(() if alike else (called,)), *read.notes, *home_notes(read)))
    write(f"\n{file} is yours to edit: what the robot is to do, what is free, how it rests.\n")
    _check(made.task, str(file))
    fitness = made.task.goal.name
    objective = f" --objective {_OBJECTIVES[fitness]}" if fitness in _OBJECTIVES else ""
    write(f"robomore check-task {file}\nrobomore run {file} --preset smoke{objective}\n")


def check_task(task: Annotated[str, TASK], /, *, picture: Path | None = None) -> None:
    """Say how a task was understood, and what is wrong with it, before anything trains.

    Parameters
    ----------
    task
        Path of a task file (.toml), or the id of an installed task.
    picture
        Draw the robot into this file (.svg or .png), with what is free in colour and numbered.
    """
    from robomore.importer.task_file import read_task_file
    from robomore.rendering.marks import draw_free
    from robomore.rendering.pictures import save_picture
    from robomore.tasks import get_task
    from robomore.tasks.registry import SUFFIX

    if task.endswith(SUFFIX):
        _tell(read_task_file(Path(task)))
    chosen = get_task(task)
    _tell_simulated(chosen)
    if picture is not None:
        save_picture(draw_free(chosen), picture, chosen.title)
        write(f"picture: {picture}\n")
    _check(chosen, task)
    write("nothing is wrong with this task\n")


def _check(task: Task, given: str) -> None:
    """Try a task out.

    Args:
        task: that is tried.
        given: its id or file, for the message.

    Raises:
        InputError: something is wrong with it.
    """
    from robomore.errors import InputError
    from robomore.testing.tasks import check_task

    try:
        check_task(task)
    except AssertionError as error:
        raise InputError(f"{given}: {error}") from None


def _tell(read: ReadTask, before: Sequence[str] = ()) -> None:
    """Say what was found in a robot and what is free, and the notes `before` that."""
    from robomore.importer.limbs import find_links, groups

    model = read.robot.spec().compile()
    lines = [
        f"{read.task.title}: {len(find_links(model))} links, {float(model.body_mass.sum()):.4g} kg"
    ]
    for name, group in groups(find_links(model), model):
        size = f"{group[0].length:.3g} m long" if group[0].length else "no limb"
        lines.append(f"  {name:20} {size:14} {', '.join(link.name for link in group)}")
    for edit, parameter in zip(read.plan.edits, read.task.parameters, strict=True):
        lines.append(
            f"  free: {parameter.name} = {parameter.reference:.4g} {parameter.unit} "
            f"({parameter.low:g} to {parameter.high:g}), the {edit.changes} of "
            f"{', '.join(edit.parts)}"
        )
    lines.append(f"  mass by {read.task.mass}")
    base, remedy = _base(model)
    lines.append(f"  its base {base}; its goal is `{read.task.goal.name}`")
    if remedy:
        lines.append(f"    if it is to move, {remedy}")
    lines += [
        f"  added by the task file: a {group.kind} of {group.torque:g} N·m for "
        f"{', '.join(group.joints)}"
        for group in read.plan.motors
    ]
    lines += [f"  note: {note}" for note in dict.fromkeys((*before, *read.notes))]
    write("\n".join(lines) + "\n")


def _base(model: mujoco.MjModel) -> tuple[str, str]:
    """Return how a robot's base moves, and what would make a fixed one move freely, in words."""
    from robomore.envs.root import find_root

    base = find_root(model).base
    if base != "fixed":
        return {"free": "moves freely", "planar": "moves in the plane of x and z"}[base], ""
    first, count = int(model.body_jntadr[1]), int(model.body_jntnum[1])
    if not count:
        remedy = "give its root a <freejoint/>, or `new` --base free"
        return "is fixed to the world, since nothing gives it a free joint", remedy
    names = ", ".join(model.joint(joint).name for joint in range(first, first + count))
    remedy = "give its root a <freejoint/> in the place of these joints"
    return f"hangs from the world by {names}", remedy


def _tell_simulated(task: Task) -> None:
    """Say what a policy sees and moves."""
    import mujoco
    import numpy as np

    from robomore.envs.compile import body_facts
    from robomore.envs.vector_env import VectorEnv

    env = VectorEnv(task, task.reference, 1)
    model, control = env.model, env.environment.control_map()
    facts = body_facts(task, task.reference)
    lines = [
        f"  volume {facts['volume']:.6f} m³, mass {facts['mass']:.4g} kg, root at "
        f"{facts['rest_height']:.3g} m at rest",
        f"  {env.observation_size} numbers are observed, {env.action_size} motors move:",
    ]
    lows, rests, highs = (control.controls(np.full(model.nu, at)) for at in (-1.0, 0.0, 1.0))
    for motor, (low, rest, high) in enumerate(zip(lows, rests, highs, strict=True)):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, motor) or f"motor {motor}"
        lines.append(f"    {name}: action -1, 0, 1 is control {low:.3g}, {rest:.3g}, {high:.3g}")
    write("\n".join(lines) + "\n")
