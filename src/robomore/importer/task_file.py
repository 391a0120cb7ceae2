"""Reads a task file: what a person writes to say what a robot of theirs is to do.

The file is TOML. `docs/own-robot.md` describes each line. What it says is checked here, before
anything is simulated, and each mistake is answered with the line's name, its value and a remedy.
"""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from keyword import iskeyword
from pathlib import Path
from typing import Literal

import msgspec

from robomore.errors import InputError
from robomore.importer.building import Plan, build
from robomore.importer.edits import MASS_MODES, Edit, MassMode, MotorGroup
from robomore.importer.limbs import find_links
from robomore.importer.reading import SIMPLE_JOINTS, Robot, read_robot
from robomore.importer.strength import strength_of
from robomore.importer.table_faults import explain
from robomore.tasks.fitness import Fitness
from robomore.tasks.portable import FitnessTerm, make_fitness
from robomore.tasks.task import Parameter, Task

_MOST_OF_A_MOTOR = 1e6
"""Largest number that an `[[actuator]]` may have, each in its SI unit."""


class ParameterTable(msgspec.Struct, forbid_unknown_fields=True):
    """A `[[parameter]]`: one free dimension."""

    name: str
    changes: Literal["length", "radius", "strength"]
    of: list[str]
    low: float
    high: float
    meaning: str
    scale: Literal["log", "linear"] = "log"


class ActuatorTable(msgspec.Struct, forbid_unknown_fields=True):
    """An `[[actuator]]`: motors for joints that have none."""

    joints: list[str]
    kind: Literal["servo", "motor"]
    torque: float
    stiffness: float = 0.0
    damping: float = 0.0
    armature: float = 0.0


class HomeTable(msgspec.Struct, forbid_unknown_fields=True):
    """`[home]`: the pose at rest."""

    joints: dict[str, float] = {}
    upright: tuple[float, float, float, float] | None = None


class HealthTable(msgspec.Struct, forbid_unknown_fields=True):
    """`[health]`: when an episode ends early."""

    tilt_degrees: float | None = None
    height: tuple[float, float] = (0.0, 1e6)


class TargetTable(msgspec.Struct, forbid_unknown_fields=True):
    """`[target]`: a place in the world that a site or a link of the robot is to reach."""

    part: str
    position: tuple[float, float, float]


class TaskTable(msgspec.Struct, forbid_unknown_fields=True):
    """All of a task file."""

    id: str
    title: str
    description: str
    robot: str
    fitness: str | FitnessTerm | list[FitnessTerm]
    reward: str
    parameter: list[ParameterTable]
    base: Literal["free", "fixed"] | None = None
    mass: MassMode = "density"
    payload: float = 0.5
    control_hz: float = 50.0
    episode_seconds: float = 20.0
    reset_noise: float = 0.05
    reach: float = 1.0
    sensors: list[str] = []
    home: HomeTable = msgspec.field(default_factory=HomeTable)
    health: HealthTable = msgspec.field(default_factory=HealthTable)
    target: TargetTable | None = None
    actuator: list[ActuatorTable] = []


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
    table = _table(path)
    robot = read_robot(path.parent / table.robot, table.base)
    plan = _plan(table, robot, path)
    task, notes = build(robot, plan)
    return ReadTask(task, robot, plan, (*robot.notes, *notes))


def _table(path: Path) -> TaskTable:
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise InputError(
            f"{path} cannot be read ({error.strerror}); `robomore new ROBOT.xml` writes a task file"
        ) from None
    except UnicodeDecodeError:
        raise InputError(f"{path} is no text in UTF-8; save it as such") from None
    except RecursionError:
        raise InputError(f"{path} is nested too deeply; write it out flat") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path} is no TOML: {error}; correct that line") from None
    try:
        return msgspec.convert(content, TaskTable)
    except msgspec.ValidationError as error:
        raise InputError(f"{path}: {explain(error, TaskTable, content)}; correct it") from None


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
            matching = [name for name in known if fnmatchcase(name, pattern)]
            if not matching:
                faults.append(f"{where}: nothing is called {pattern!r}; there are {_list(known)}")
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
        faults += _parameter_faults(given)
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
        if not given.low <= reference <= given.high:
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
            if low < high and not low <= angle <= high:
                faults.append(
                    f"[home] {name} = {angle:g}, which is outside its range of {low:.4g} to "
                    f"{high:.4g}"
                )
    if not table.parameter:
        faults.append("it has no [[parameter]]: nothing is free")
    names = [one.name for one in table.parameter]
    faults += [
        f"two parameters are called {n!r}" for n in sorted({n for n in names if names.count(n) > 1})
    ]
    faults += _number_faults(table)
    if faults:
        raise InputError(f"{path}: " + "; ".join(faults))
    return Plan(
        id=table.id,
        title=table.title,
        description=table.description.strip(),
        fitness=_fitness(table),
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
        upright=table.home.upright or robot.upright,
        tilt_degrees=table.health.tilt_degrees,
        healthy_height=table.health.height,
        target=(table.target.part, table.target.position) if table.target else None,
    )


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


def _parameter_faults(given: ParameterTable) -> list[str]:
    faults = []
    if not given.of:
        faults.append(f"[[parameter]] {given.name}: `of` is empty; name the parts that it changes")
    if not given.name.isidentifier() or iskeyword(given.name):
        faults.append(
            f"[[parameter]] {given.name!r}: give a name of letters, digits and _ that is no word "
            "of Python's"
        )
    if not 0 < given.low < given.high:
        faults.append(
            f"[[parameter]] {given.name}: low = {given.low:g} and high = {given.high:g}; low has "
            "to be above 0 and below high"
        )
    if not given.meaning.strip():
        faults.append(f"[[parameter]] {given.name}: say its meaning; designers read it")
    return faults


def _number_faults(table: TaskTable) -> list[str]:
    faults = []
    for name, low, high in (
        ("payload", 0.0, 1.0),
        ("control_hz", 1.0, 1000.0),
        ("episode_seconds", 0.1, 3600.0),
        ("reset_noise", 0.0, 1.0),
        ("reach", 0.01, 1.0),
    ):
        value = getattr(table, name)
        if not low <= value <= high:
            faults.append(f"{name} = {value:g}; give a number from {low:g} to {high:g}")
    tilt = table.health.tilt_degrees
    if tilt is not None and not 0 < tilt <= 180:
        faults.append(
            f"[health] tilt_degrees = {tilt:g}; give a number above 0, 180 at most, or leave it out"
        )
    if table.home.upright is not None and not 0 < math.hypot(*table.home.upright) < math.inf:
        faults.append(
            f"[home] upright = {list(table.home.upright)}; give a quaternion (w, x, y, z) that is "
            "not 0"
        )
    for one in table.actuator:
        for name in ("torque", "stiffness", "damping", "armature"):
            if not 0 <= (value := getattr(one, name)) <= _MOST_OF_A_MOTOR:
                faults.append(
                    f"[[actuator]] {name} = {value:g}; give a number from 0 to {_MOST_OF_A_MOTOR:g}"
                )
        if one.kind == "motor" and one.stiffness:
            faults.append(
                f"[[actuator]] stiffness = {one.stiffness:g} is a servo's; leave it out, or give "
                'kind = "servo"'
            )
    if table.health.height[0] >= table.health.height[1]:
        faults.append(f"[health] height = {list(table.health.height)}; the first has to be smaller")
    if not table.id or not all(one.isalnum() or one in "-_" for one in table.id):
        faults.append(f"id = {table.id!r}; give one of letters, digits, - and _")
    if table.mass not in MASS_MODES:
        faults.append(f"mass = {table.mass!r}; choose one of {', '.join(MASS_MODES)}")
    return faults


def _list(names: list[str]) -> str:
    shown = ", ".join(names[:30])
    return shown + (f" and {len(names) - 30} more" if len(names) > 30 else "")
