"""The lines of a task file as they are read, and which numbers may stand in them."""

from __future__ import annotations

import math
import re
import tomllib
from keyword import iskeyword
from pathlib import Path
from typing import Literal

import msgspec

from robomore.errors import InputError
from robomore.importer.edits import MASS_MODES, MassMode
from robomore.importer.table_faults import explain
from robomore.plain_files import what_stands_at
from robomore.suggestions import path_meant
from robomore.tasks.portable import FitnessTerm

_LARGEST = 1e6
"""Largest number of an `[[actuator]]` or a `[[parameter]]`, each in its SI unit."""

_FARTHEST = 1000.0
"""Distance in m that a target may have along each axis."""

_MOST_BYTES = 2**20
"""Bytes of a task file."""

_MOST_TERMS = 100
"""Terms of a fitness."""

_DEEP_KEY = re.compile(r"(?<![\w\"'-])(?:[\w\"'-]++[ \t]*+\.[ \t]*+){30}")
"""A dotted key that makes a table within 30 others, for which `tomllib` takes minutes."""


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
    height: tuple[float, float] | None = None


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


def read_table(path: Path) -> TaskTable:
    """Return the lines of a task file.

    Raises:
        InputError: it cannot be read, or a line is missing or has another form.
    """
    # A pipe would be waited for, and a device may have no end.
    if (found := what_stands_at(path)) != "a file":
        said = f"{path} is {found}." if found else f"there is no file {path}.{path_meant(path)}"
        raise InputError(f"{said} Name a task file; `robomore new ROBOT.xml` writes one")
    try:
        with path.open("rb") as file:
            text = file.read(_MOST_BYTES + 1).decode("utf-8-sig")
        if len(text) > _MOST_BYTES or _DEEP_KEY.search(text):
            raise InputError(
                f"{path} has more than {_MOST_BYTES >> 20} MiB, or a key with 30 dots; write less"
            )
        content = tomllib.loads(text)
    except OSError as error:
        raise InputError(
            f"{path} cannot be read ({error.strerror}); `robomore new ROBOT.xml` writes a task file"
        ) from None
    except UnicodeDecodeError:
        raise InputError(f"{path} is no text in UTF-8; save it as such") from None
    except RecursionError:
        raise InputError(f"{path} is nested too deeply; write it out flat") from None
    except ValueError as error:  # of TOML, or a number of thousands of digits
        raise InputError(f"{path} is no TOML: {error}; correct that line") from None
    try:
        return msgspec.convert(content, TaskTable)
    except msgspec.ValidationError as error:
        raise InputError(f"{path}: {explain(error, TaskTable, content)}; correct it") from None


def parameter_faults(given: ParameterTable) -> list[str]:
    """Return what is wrong with a `[[parameter]]`, whatever the robot is."""
    faults = []
    if not given.of:
        faults.append(f"[[parameter]] {given.name}: `of` is empty; name the parts that it changes")
    if not given.name.isidentifier() or iskeyword(given.name):
        faults.append(
            f"[[parameter]] {given.name!r}: give a name of letters, digits and _ that is no word "
            "of Python's"
        )
    if not 0 < given.low < given.high <= _LARGEST:
        faults.append(
            f"[[parameter]] {given.name}: low = {given.low:g} and high = {given.high:g}; low has "
            f"to be above 0 and below high, which is {_LARGEST:g} at most"
        )
    if not given.meaning.strip():
        faults.append(f"[[parameter]] {given.name}: say its meaning; designers read it")
    return faults


def number_faults(table: TaskTable) -> list[str]:
    """Return which numbers and names of a task file cannot be, whatever the robot is."""
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
            if not 0 <= (value := getattr(one, name)) <= _LARGEST:
                faults.append(
                    f"[[actuator]] {name} = {value:g}; give a number from 0 to {_LARGEST:g}"
                )
        if one.kind == "motor" and one.stiffness:
            faults.append(
                f"[[actuator]] stiffness = {one.stiffness:g} is a servo's; leave it out, or give "
                'kind = "servo"'
            )
    if table.health.height and table.health.height[0] >= table.health.height[1]:
        faults.append(f"[health] height = {list(table.health.height)}; the first has to be smaller")
    if not re.fullmatch(r"[\w-]{1,64}", table.id):
        faults.append(f"id = {table.id[:80]!r}; give one of letters, digits, - and _, 64 at most")
    if isinstance(table.fitness, list) and len(table.fitness) > _MOST_TERMS:
        faults.append(f"fitness has {len(table.fitness):,} terms; give {_MOST_TERMS} at most")
    if table.target and not all(abs(place) <= _FARTHEST for place in table.target.position):
        faults.append(
            f"[target] position = {list(table.target.position)}; give x, y, z from "
            f"-{_FARTHEST:g} to {_FARTHEST:g} m"
        )
    if table.mass not in MASS_MODES:
        faults.append(f"mass = {table.mass!r}; choose one of {', '.join(MASS_MODES)}")
    return faults
