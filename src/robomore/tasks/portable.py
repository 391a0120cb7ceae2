"""A task that comes from a file, as bytes: workers, sandboxes and run folders need nothing else.

A task of an installed package is known by its id wherever that package is. One of a task file is
known nowhere else, so it travels whole: the filled-in template, its meshes, and its options. What
is read here is data; nothing in it names code to be imported.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import partial
from typing import Annotated, Any

import msgspec

from robomore.errors import InputError
from robomore.tasks.fitness import Fitness, Term
from robomore.tasks.meshes import MOST_BYTES_OF_ALL, check_meshes
from robomore.tasks.sizes import check_sizes
from robomore.tasks.task import Parameter, Task, Values
from robomore.tasks.trajectory import Trajectory
from robomore.text import odd_characters

ENVIRONMENT = "robomore.envs.robots.own_robot:OwnRobotEnvironment"
"""The one environment of such tasks."""

_MOST_DATA = 4 * 2**20
"""Bytes of everything else in a task."""

_MOST_STEPS = 1_000_000
"""Steps of MuJoCo in an episode: more than half an hour at a time step of 2 ms."""

_LONGEST_TITLE, _LONGEST_LINE, _LONGEST_DESCRIPTION = 200, 1_000, 10_000
"""Characters of a title, of any other text that is shown in one line, and of a description."""

_MESH = re.compile(r"[^/\\]{1,200}\.(?:stl|obj|msh)", re.IGNORECASE)
"""The name of a mesh: a path could be one of this machine."""

MOST_CONTENT = MOST_BYTES_OF_ALL * 4 // 3 + 2 * _MOST_DATA
"""Bytes of a whole task, in which meshes are written as text."""


@dataclass(frozen=True, slots=True)
class FixedOptions:
    """Options of an environment that are the same for all morphologies."""

    options: Mapping[str, Any]

    def __call__(self, values: Values) -> dict[str, Any]:
        """Return the options."""
        return dict(self.options)


@dataclass(frozen=True, slots=True)
class FitnessTerm:
    """A measure of a fitness as data.

    Attributes:
        measure: its name; empty for a function.
        options: of the measure.
        weight: in the sum.
        function: text of a Python function of a `Trajectory`, in the place of a named measure.
        unit: of what the function returns.
        meaning: of it, in words.
        foreign: whether the function came out of a run's folder, so that no process executes it.
    """

    measure: str = ""
    options: dict[str, Any] = field(default_factory=dict)
    weight: float = 1.0
    function: str = ""
    unit: str = ""
    meaning: str = ""
    foreign: bool = False


class _Outline(msgspec.Struct):
    """The field of a content that may be long, not read yet."""

    assets: msgspec.Raw = msgspec.Raw()


_Number = Annotated[float, msgspec.Meta(ge=-1e6, le=1e6)]
_Share = Annotated[float, msgspec.Meta(ge=0, le=100)]


class _Options(msgspec.Struct, forbid_unknown_fields=True):
    """The options of a robot's environment, each of which may be missing."""

    frame_skip: int = 1
    home: dict[str, _Number] = {}
    upright: tuple[_Number, _Number, _Number, _Number] = (1.0, 0.0, 0.0, 0.0)
    healthy_tilt: _Share | None = None
    healthy_height: tuple[_Number, _Number] | None = None
    reset_noise: _Share = 0.0
    reach: _Share = 1.0
    sensors: tuple[str, ...] = ()
    tip: str = ""


@dataclass(frozen=True, slots=True)
class _Content:
    """The fields of a `Task` that are data."""

    id: str
    title: str
    description: str
    fitness: tuple[FitnessTerm, ...]
    unit: str
    template: str
    parameters: tuple[Parameter, ...]
    reward: str
    options: dict[str, Any]
    episode_steps: int
    version: int
    mass: str
    assets: dict[str, bytes] = field(default_factory=dict)
    mesh_volumes: dict[str, float] = field(default_factory=dict)
    radii: tuple[str, ...] | None = None


def task_content(task: Task) -> bytes:
    """Return a task of a file as bytes; nothing for one that its id says all of."""
    if not isinstance(task.options, FixedOptions):
        return b""
    values = {one.name: getattr(task, one.name) for one in fields(_Content) if one.name != "unit"}
    values["options"] = dict(task.options.options)
    values["fitness"] = tuple(map(_as_data, task.goal.terms))
    return msgspec.json.encode(_Content(**values, unit=task.goal.unit), order="sorted")


def task_from_content(content: bytes, trusted: bool = True) -> Task:
    """Return the task that `task_content` wrote.

    Args:
        content: what it wrote.
        trusted: whether it comes from this user. A function in it is not executed otherwise.

    Raises:
        InputError: it is not such a content, or it asks for files that are not in it.
    """
    try:
        # Before anything is made of it: a number takes two bytes here and 32 in memory.
        meshes = len(bytes(msgspec.json.decode(content, type=_Outline).assets))
        if len(content) > MOST_CONTENT or len(content) - meshes > _MOST_DATA:
            raise InputError(
                f"the content of a task has {len(content):,} bytes, {meshes:,} of them meshes; at "
                f"most {_MOST_DATA:,} besides meshes are read"
            )
        read = msgspec.json.decode(content, type=_Content)
    except (msgspec.DecodeError, RecursionError) as error:
        raise InputError(f"the content of a task is damaged: {error}") from None
    if not re.fullmatch(r"[\w-][\w. -]{0,98}", read.id) or read.id.endswith(".toml"):
        raise InputError(f"a task in a folder has the id {read.id[:80]!r}; it is no plain name")
    _check_options(read)
    values = {one.name: getattr(read, one.name) for one in fields(_Content) if one.name != "unit"}
    values["options"] = FixedOptions(read.options)
    values["fitness"] = make_fitness(read.fitness, read.unit, trusted)
    refuse_files(read.id, read.template, read.assets)
    task = Task(**values, environment=ENVIRONMENT)
    refuse_texts(task)
    return task


def refuse_texts(task: Task) -> None:
    """Refuse texts of a task that do not fit where they are shown.

    Raises:
        InputError: naming the text.
    """
    lines = {"title": task.title, "mass": task.mass, "unit of the fitness": task.goal.unit}
    for number, term in enumerate(task.goal.terms, start=1):
        lines[f"unit of measure {number}"] = term.measure.unit
        lines[f"meaning of measure {number}"] = term.measure.meaning
    for one in task.parameters:
        lines[f"name {one.name[:40]!r}"] = one.name
        lines[f"unit of {one.name[:40]!r}"] = one.unit
        lines[f"meaning of {one.name[:40]!r}"] = one.meaning
    for what, text in lines.items():
        most = _LONGEST_TITLE if what == "title" else _LONGEST_LINE
        if len(text) > most or "\n" in text or "\t" in text or odd_characters(text):
            raise InputError(
                f"{task.id}: its {what} is {text[:80]!r}; give one line of at most {most:,} "
                "characters that can be printed"
            )
    if len(task.description) > _LONGEST_DESCRIPTION or (odd := odd_characters(task.description)):
        fault = f"holds {odd[0]!r}" if len(task.description) <= _LONGEST_DESCRIPTION else "is long"
        raise InputError(
            f"{task.id}: its description {fault}; give at most {_LONGEST_DESCRIPTION:,} "
            "characters that can be printed"
        )


def _check_options(read: _Content) -> None:
    """Refuse options that the environment does not have, or that nobody can wait for."""
    try:
        options = msgspec.convert(read.options, _Options)
    except msgspec.ValidationError as error:
        raise InputError(f"{read.id[:80]!r}: its options are none of a robot: {error}") from None
    skipped, steps = options.frame_skip, read.episode_steps
    if min(skipped, steps) < 1 or skipped * steps > _MOST_STEPS:
        raise InputError(
            f"{read.id[:80]!r}: an episode of {steps} control steps of {skipped} steps of MuJoCo "
            f"each; at least 1 and at most {_MOST_STEPS:,} in all are simulated"
        )


def make_fitness(
    terms: Sequence[FitnessTerm], unit: str | None = None, trusted: bool = True
) -> Fitness:
    """Return a fitness from its terms as data.

    Raises:
        InputError: a measure, an option or a function is wrong.
    """
    parts: list[tuple[float, str | Fitness]] = []
    for term in terms:
        if term.function:
            if term.measure or term.options:
                raise InputError(
                    f"{term.measure or 'options'!r} stands beside the text of a function in one "
                    "term of the fitness; give a measure with its options, or a function"
                )
            if NAME not in term.function:
                raise InputError(f"the function of the fitness has to define {NAME}(trajectory)")
            executed = trusted and not term.foreign
            own = partial(_own_value if executed else _not_executed, term.function)
            meaning = term.meaning or "a function of its own"
            parts.append((term.weight, Fitness.own(own, unit=term.unit, meaning=meaning)))
        else:
            # A name alone may be a measure of which less is better.
            named = Fitness.of(term.measure, **term.options) if term.options else term.measure
            parts.append((term.weight, named))
    return Fitness.sum(*parts, unit=unit)


NAME = "fitness"
"""Name of a function of one's own in a task file."""


def is_foreign(fitness: Fitness) -> bool:
    """Return whether a fitness has a function that came out of a run's folder."""
    functions = [term.measure.function for term in fitness.terms]
    return any(getattr(one, "func", None) is _not_executed for one in functions)


def _as_data(term: Term) -> FitnessTerm:
    function = term.measure.function
    if isinstance(function, partial):
        measure = term.measure
        (source,) = function.args
        foreign = function.func is _not_executed
        return FitnessTerm("", {}, term.weight, source, measure.unit, measure.meaning, foreign)
    return FitnessTerm(term.name, dict(term.options), term.weight)


def _own_value(source: str, trajectory: Trajectory) -> float:
    """Return what the function in `source`, the text of a person's own task file, gives."""
    namespace: dict[str, Any] = {}
    exec(compile(source, "<fitness>", "exec"), namespace)
    return float(namespace[NAME](trajectory))


def _not_executed(source: str, trajectory: Trajectory) -> float:
    """Refuse a function that came out of a run's folder, which may be somebody else's.

    Raises:
        InputError: always.
    """
    raise InputError("the fitness is a function that a run's folder holds; it is not executed")


def refuse_files(id: str, template: str, assets: Mapping[str, bytes]) -> None:
    """Refuse a template that reads files which do not travel with it.

    Raises:
        InputError: naming the file.
    """
    for name in assets:
        if not _MESH.fullmatch(name):
            raise InputError(
                f"{id}: {name[:80]!r} is no name of a mesh; give one without folders that ends in "
                ".stl, .obj or .msh"
            )
    check_meshes(id, assets)
    # What hides a part from these checks must not come to light once the template is filled.
    if re.search(r"<[!?]", template):
        raise InputError(f"{id}: its template holds comments or declares entities; leave them out")
    # MuJoCo knows no namespaces: it takes `<include xmlns="…">` for an `include`.
    if "xmlns" in template:
        raise InputError(f"{id}: its template names a namespace (xmlns); write plain MJCF")
    try:
        root = ET.fromstring(template)
    except ET.ParseError as error:
        raise InputError(f"{id}: its template is no XML ({error})") from None
    check_sizes(id, root)
    for part in root.iter():
        if part.tag in ("include", "extension", "plugin", "model"):
            raise InputError(f"{id}: its template holds <{part.tag}>, which reads other files")
        named = [value for name, value in part.attrib.items() if name.startswith("file")]
        named += [value for name, value in part.attrib.items() if name.endswith("dir") and value]
        for name in named:
            if name not in assets and part.tag != "compiler" and part.tag != "light":
                raise InputError(f"{id}: its template reads the file {name!r}, which is not in it")
