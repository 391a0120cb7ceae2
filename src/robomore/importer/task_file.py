"""Reads a task file: what a person writes to say what a robot of theirs is to do.

The file is TOML (`task_table`). `docs/own-robot.md` describes each line. What it says is checked
before anything is simulated, and each mistake is answered with the line's name, its value and a
remedy.
"""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from robomore.envs.root import SIMPLE_JOINTS
from robomore.errors import InputError
from robomore.importer.building import Plan, build
from robomore.importer.edits import Edit, MotorGroup
from robomore.importer.limbs import find_links
from robomore.importer.ranges import ROUNDING, unit_of
from robomore.importer.reading import Robot, read_robot
from robomore.importer.strength import strength_of
from robomore.importer.task_table import TaskTable, number_faults, parameter_faults, read_table
from robomore.tasks.fitness import Fitness
from robomore.tasks.portable import FitnessTerm, make_fitness
from robomore.tasks.task import Parameter, Task
from robomore.text import listed


@dataclass(frozen=True, slots=True)
class ReadTask:
    """A task and what it was made from.

    Attributes:
        task: that a file describes.
        robot: that it was made from.
        plan: what the file asks for, with all names resolved.
        notes: what was changed, left out or chosen on the way, in words.
    """

    task: Task
    robot: Robot
    plan: Plan
    notes: tuple[str, ...]


def read_task(path: Path) -> Task:
    """Return the task that a file describes.

    Raises:
        InputError: it cannot be read, or something in it is wrong.
    """
    return read_task_file(path).task


def read_task_file(path: Path) -> ReadTask:
    """Return the task that a file describes, and how it was understood.

    Raises:
        InputError: it cannot be read, or something in it is wrong; all that is found is named.
    """
    table = read_table(path)
    robot = read_robot(path.parent / table.robot, table.base)
    plan = _plan(table, robot, path)
    task, notes = build(robot, plan)
    return ReadTask(task, robot, plan, (*robot.notes, *notes))


def _plan(table: TaskTable, robot: Robot, path: Path) -> Plan:
    """Return what a file asks for with the names of parts resolved.

    Raises:
        InputError: naming every mistake.
    """
    model = robot.spec().compile()
    links = find_links(model)
    numbers = [n for n in range(model.njnt) if int(model.jnt_type[n]) in SIMPLE_JOINTS]
    joints = [model.joint(number).name for number in numbers]
    faults: list[str] = []

    def resolved(patterns: list[str], known: list[str], where: str) -> tuple[str, ...]:
        found: list[str] = []
        for pattern in patterns:
            # A name may hold brackets, which would stand for one of several characters.
            matching = [pattern] if pattern in known else fnmatch.filter(known, pattern)
            if not matching:
                faults.append(
                    f"{where}: nothing is called {pattern!r}; there are {listed(known, 30)}"
                )
            found += [name for name in matching if name not in found]
        return tuple(found)

    motors = tuple(
        MotorGroup(
            resolved(one.joints, joints, "[[actuator]] joints"),
            one.kind,
            one.torque,
            one.stiffness,
            one.damping,
            one.armature,
        )
        for one in table.actuator
    )
    driven: set[str] = set()
    for one in motors:
        for name in one.joints:
            if name in driven:
                faults.append(f"[[actuator]]: two name the joint `{name}`; name it in one")
            driven.add(name)
            limited = bool(model.joint(name).range.any())
            if one.kind == "servo" and not limited:
                faults.append(
                    f"[[actuator]]: the joint `{name}` turns without limits, so a servo has no "
                    'range to move in; give it kind = "motor"'
                )
        if one.torque <= 0 or (one.kind == "servo" and one.stiffness <= 0):
            faults.append("[[actuator]]: torque and stiffness have to be above 0")
    edits, parameters = [], []
    for given in table.parameter:
        known = joints if given.changes == "strength" else [n for n in links if links[n].depth]
        parts = resolved(given.of, known, f"[[parameter]] {given.name}")
        faults += parameter_faults(given)
        if not parts:
            continue
        if given.changes == "strength":
            sizes = [strength_of(model, motors, name) for name in parts]
        else:
            sizes = [getattr(links[name], given.changes) for name in parts]
        reference = max(sizes)
        if not min(sizes) > 0:
            lacking = parts[sizes.index(min(sizes))]
            faults.append(f"[[parameter]] {given.name}: `{lacking}` has no {given.changes}")
            continue
        if given.low < given.high and not given.low <= reference <= given.high:
            faults.append(
                f"[[parameter]] {given.name}: the robot has {reference:.4g}, which is outside "
                f"{given.low:g} to {given.high:g}"
            )
        reference = min(max(float(f"{reference:.9g}"), given.low), given.high)
        edits.append(Edit(given.name, given.changes, parts, reference))
        unit = "N·m" if given.changes == "strength" else "m"
        parameters.append(
            Parameter(
                given.name, given.low, given.high, reference, given.meaning, unit, given.scale
            )
        )
    for name, angle in table.home.joints.items():
        if resolved([name], joints, "[home] joints") and name in joints:
            low, high = model.joint(name).range
            if low < high and not low - ROUNDING <= angle <= high + ROUNDING:
                unit = unit_of(model, name)
                faults.append(
                    f"[home] {name} = {angle:g}, which is outside its range of {low:.4g} to "
                    f"{high:.4g} {unit}; give a number of {unit} in it, or widen the joint's range "
                    "in the robot's file"
                )
    if not table.parameter:
        faults.append("it has no [[parameter]]: nothing is free")
    names = [one.name for one in table.parameter]
    faults += [
        f"two parameters are called {n!r}" for n in sorted({n for n in names if names.count(n) > 1})
    ]
    faults += number_faults(table)
    try:
        fitness = _fitness(table)
    except InputError as error:
        faults.append(f"fitness: {error}")
    if faults:
        raise InputError(f"{path}: " + "; ".join(faults))
    return Plan(
        id=table.id,
        title=table.title,
        description=table.description.strip(),
        fitness=fitness,
        reward=table.reward,
        parameters=tuple(parameters),
        edits=tuple(edits),
        motors=motors,
        mass=table.mass,
        payload=table.payload,
        control_hz=table.control_hz,
        episode_seconds=table.episode_seconds,
        reset_noise=table.reset_noise,
        reach=table.reach,
        sensors=tuple(table.sensors),
        home={**robot.home, **table.home.joints},
        upright=_unit(table.home.upright or robot.upright),
        tilt_degrees=table.health.tilt_degrees,
        healthy_height=table.health.height,
        target=(table.target.part, table.target.position) if table.target else None,
    )


def _unit(quaternion: Sequence[float]) -> tuple[float, ...]:
    """Return a quaternion of length 1, as which alone it is a rotation."""
    size = math.hypot(*quaternion)
    return tuple(number / size for number in quaternion)


def _fitness(table: TaskTable) -> Fitness:
    """Return what a file says of its fitness; a target is that of its own table."""
    given = table.fitness
    terms = [FitnessTerm(given)] if isinstance(given, str) else given
    terms = [terms] if isinstance(terms, FitnessTerm) else terms
    if table.target:
        target = {"target": list(table.target.position), "part": table.target.part, "radius": 0.05}
        terms = [
            replace(one, options=target | one.options) if one.measure == "target-reached" else one
            for one in terms
        ]
    return make_fitness(terms)
