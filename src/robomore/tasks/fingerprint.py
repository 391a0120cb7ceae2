"""What a task consists of, as digests: an edited task is another task.

Functions of a task are covered twice: by their text and what it refers to, and by their results at
the reference and at fixed random parameters around it. The same task gives the same digests in
every process and on every machine. Nothing is imported for it, least of all a simulator.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
from collections.abc import Callable
from typing import Any

from robomore.identity import content_key
from robomore.tasks.code_content import content
from robomore.tasks.module_source import class_sources
from robomore.tasks.task import Task, Values

PROBES = 16
"""Random parameters, besides the reference, that a task's functions are called with."""

_HEX_DIGITS = 16


def fingerprint(task: Task) -> dict[str, str]:
    """Return 16 hex digits for each part of a task, by the part's name.

    Title and id are left out: no number depends on them.
    """
    return dict(_fingerprint(_Same(task)))


def task_key(task: Task) -> str:
    """Return one content key of 24 hex digits for all that a task consists of."""
    return content_key(fingerprint(task))


class _Same:
    """A task as a key of a cache, by identity: its mappings have no hash."""

    def __init__(self, task: Task) -> None:
        self.task = task

    def __hash__(self) -> int:
        return id(self.task)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and self.task is other.task


@functools.lru_cache(maxsize=64)
def _fingerprint(same: _Same) -> dict[str, str]:
    task = same.task
    probes = [dict(zip(task.names, task.reference, strict=True)), *_probes(task)]
    rules = [[rule.text, content(rule.violation)] for rule in task.rules]
    violations = [_results(rule.violation, probes) for rule in task.rules]
    parts: dict[str, Any] = {
        "template": task.template,
        "parameters": [dataclasses.asdict(one) for one in task.parameters],
        "constants": sorted((name, repr(value)) for name, value in task.constants.items()),
        "options": [content(task.options), _results(task.options, probes)],
        "rules": [rules, violations],
        "shapes": [content(task.shapes), _results(functools.partial(_solids, task), probes)],
        "reward": task.reward,
        "environment": [task.environment, _environment(task.environment)],
        "fitness": task.fitness,
        "terrain": dataclasses.asdict(task.terrain) if task.terrain else None,
        "episode": task.episode_steps,
        "description": task.description,
        "version": task.version,
    }
    return {name: content_key(part)[:_HEX_DIGITS] for name, part in parts.items()}


def _solids(task: Task, values: Values) -> Any:
    shapes = task.shapes(values)
    return shapes, sum(shape.volume for shape in shapes)


def _results(function: Callable[[Values], Any], probes: list[dict[str, float]]) -> list[Any]:
    """Return what a function of a task gives at each probe; an exception counts by its type."""
    found = []
    for values in probes:
        try:
            found.append(content(function(dict(values)), computed=True))
        except Exception as error:  # noqa: BLE001  # any fault of a task is a fact about it
            found.append(["raised", type(error).__name__])
    return found


def _probes(task: Task) -> list[dict[str, float]]:
    """Return parameters around the reference: a quarter of it to twice as much, valid or not.

    They do not depend on the bounds, so that another bound changes the part `parameters` alone.
    """
    return [
        {
            one.name: one.reference * (0.25 + 1.75 * share) if one.reference else share - 0.5
            for one in task.parameters
            for share in [_share(one.name, index)]
        }
        for index in range(PROBES)
    ]


def _share(name: str, index: int) -> float:
    digest = hashlib.sha256(f"{name} {index}".encode()).digest()
    return int.from_bytes(digest[:6], "big") / 2**48


@functools.lru_cache(maxsize=64)
def _environment(reference: str) -> dict[str, str]:
    module, _, name = reference.partition(":")
    return class_sources(module, name)
