"""A task that comes from a file, as bytes: workers, sandboxes and run folders need nothing else.

A task of an installed package is known by its id wherever that package is. One of a task file is
known nowhere else, so it travels whole: the filled-in template, its meshes, and its options. What
is read here is data; nothing in it names code to be imported.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal

import msgspec

from robomore.errors import InputError
from robomore.tasks.task import Parameter, Task, Values

ENVIRONMENT = "robomore.envs.robots.own_robot:OwnRobotEnvironment"
"""The one environment of such tasks."""

_MOST_ASSETS = 64 * 2**20
"""Bytes of meshes that a task may carry."""


@dataclass(frozen=True, slots=True)
class FixedOptions:
    """Options of an environment that are the same for all morphologies."""

    options: Mapping[str, Any]

    def __call__(self, values: Values) -> dict[str, Any]:
        """Return the options."""
        return dict(self.options)


@dataclass(frozen=True, slots=True)
class _Content:
    """The fields of a `Task` that are data."""

    id: str
    title: str
    description: str
    fitness: Literal["distance", "height"]
    template: str
    parameters: tuple[Parameter, ...]
    reward: str
    options: dict[str, Any]
    episode_steps: int
    version: int
    mass: str
    assets: dict[str, bytes] = field(default_factory=dict)
    mesh_volumes: dict[str, float] = field(default_factory=dict)


def task_content(task: Task) -> bytes:
    """Return a task of a file as bytes; nothing for one that its id says all of."""
    if not isinstance(task.options, FixedOptions):
        return b""
    values = {one.name: getattr(task, one.name) for one in fields(_Content)}
    values["options"] = dict(task.options.options)
    return msgspec.json.encode(_Content(**values), order="sorted")


def task_from_content(content: bytes) -> Task:
    """Return the task that `task_content` wrote.

    Raises:
        InputError: it is not such a content, or it asks for files that are not in it.
    """
    try:
        read = msgspec.json.decode(content, type=_Content)
    except (msgspec.DecodeError, RecursionError) as error:
        raise InputError(f"the content of a task is damaged: {error}") from None
    values = {one.name: getattr(read, one.name) for one in fields(_Content)}
    values["options"] = FixedOptions(read.options)
    refuse_files(read.id, read.template, read.assets)
    return Task(**values, environment=ENVIRONMENT)


def refuse_files(id: str, template: str, assets: Mapping[str, bytes]) -> None:
    """Refuse a template that reads files which do not travel with it.

    Raises:
        InputError: naming the file.
    """
    if sum(map(len, assets.values())) > _MOST_ASSETS:
        raise InputError(
            f"{id}: its meshes have more than {_MOST_ASSETS // 2**20} MiB; use simpler"
        )
    if re.search(r"<!(DOCTYPE|ENTITY)", template):
        raise InputError(f"{id}: its template declares entities; write plain MJCF")
    try:
        root = ET.fromstring(template)
    except ET.ParseError as error:
        raise InputError(f"{id}: its template is no XML ({error})") from None
    for part in root.iter():
        if part.tag in ("include", "extension", "plugin", "model"):
            raise InputError(f"{id}: its template holds <{part.tag}>, which reads other files")
        named = [value for name, value in part.attrib.items() if name.startswith("file")]
        named += [value for name, value in part.attrib.items() if name.endswith("dir") and value]
        for name in named:
            if name not in assets and part.tag != "compiler" and part.tag != "light":
                raise InputError(f"{id}: its template reads the file {name!r}, which is not in it")
