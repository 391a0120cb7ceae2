"""What a task consists of, as digests: an edited task is another task.

The functions of a task count by their results, at the reference and at fixed random parameters
around it, and by the text of the modules that they come from: an edit there may change a case that
no probe meets. The same task gives the same digests in every process and on every machine. Nothing
is imported for it, least of all a simulator.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
from collections.abc import Callable
from typing import Any

from robomore.identity import content_key
from robomore.tasks.fitness import Fitness, Term
from robomore.tasks.own_source import own_source
from robomore.tasks.task import Rule, Task, Values

PROBES = 16
"""Random parameters, besides the reference, that a task's functions are called with."""

_HEX_DIGITS = 16


def fingerprint(task: Task) -> dict[str, str]:
    """Return 16 hex digits for each part of a task, by the part's name.

    Title and id are left out: no number depends on them. `code` is the text of the modules that the
    task's functions come from.
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
    rules = (*task.rules, *task.search_rules)
    measured = [term.measure.function for term in task.goal.terms]
    functions = [task.options, task.shapes, *(rule.violation for rule in rules), *measured]
    modules = {getattr(function, "__module__", None) or "" for function in functions}
    parts: dict[str, Any] = {
        "template": task.template,
        "parameters": [dataclasses.asdict(one) for one in task.parameters],
        "constants": sorted((name, repr(value)) for name, value in task.constants.items()),
        "options": _results(task.options, probes),
        "rules": [_rule(rule, probes) for rule in task.rules],
        "search rules": [_rule(rule, probes) for rule in task.search_rules],
        "shapes": _results(lambda values: [one.volume for one in task.solids(values)], probes),
        "reward": task.reward,
        "environment": [task.environment, own_source(task.environment.partition(":")[0])],
        "code": [own_source(module) for module in sorted(modules)],
        "fitness": _fitness(task.goal),
        "terrain": dataclasses.asdict(task.terrain) if task.terrain else None,
        "episode": task.episode_steps,
        "description": task.description,
        "version": task.version,
    }
    if task.assets or task.mass:
        sums = [[name, hashlib.sha256(data).hexdigest()] for name, data in task.assets.items()]
        parts["assets"] = [sorted(sums), sorted(task.mesh_volumes.items()), task.mass]
    if task.radii is not None:
        parts["parameters"].append(sorted(task.radii))
    return {name: content_key(part)[:_HEX_DIGITS] for name, part in parts.items()}


def _fitness(fitness: Fitness) -> list[Any]:
    terms = [
        [term.name, term.weight, _plain(dict(term.options)), term.measure.unit, _bound(term)]
        for term in fitness.terms
    ]
    return [terms, fitness.unit, fitness.meaning]


def _bound(term: Term) -> list[Any]:
    """Return the values that a function of the task's author carries besides its module's text."""
    function: Any = term.measure.function if term.own else None
    cells = [cell.cell_contents for cell in getattr(function, "__closure__", None) or ()]
    kept = [getattr(function, name, None) for name in ("args", "keywords", "__defaults__")]
    return [getattr(function, "__qualname__", ""), *map(_plain, [*cells, *kept])]


def _rule(rule: Rule, probes: list[dict[str, float]]) -> list[Any]:
    return [rule.text, _results(rule.violation, probes)]


def _results(function: Callable[[Values], Any], probes: list[dict[str, float]]) -> list[Any]:
    """Return what a function of a task gives at each probe; an exception counts by its type."""
    found = []
    for values in probes:
        try:
            found.append(_plain(function(dict(values))))
        except Exception as error:  # noqa: BLE001  # any fault of a task is a fact about it
            found.append(["raised", type(error).__name__])
    return found


def _plain(value: Any) -> Any:
    """Return a result as data; numbers rounded, since libraries differ in their last digits."""
    match value:
        case dict():
            return sorted([str(name), _plain(one)] for name, one in value.items())
        case list() | tuple():
            return [_plain(one) for one in value]
        case float():
            return f"{value:.9g}"
        case None | bool() | int() | str():
            return repr(value)
    return type(value).__name__


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
