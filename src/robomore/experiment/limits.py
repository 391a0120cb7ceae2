"""Limits of a run on volume and density, as rules of the task that is searched."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from robomore.envs.compile import body_facts
from robomore.errors import InputError, InvalidMorphology
from robomore.search.population import start
from robomore.settings import RunSettings
from robomore.tasks import Task
from robomore.tasks.task import Rule, Values
from robomore.tasks.unit_space import UnitSpace
from robomore.types import Morphology

_PROBES = 4
"""Random morphologies that tell how a robot's mass follows from its shape."""


def limited(task: Task, settings: RunSettings, *, draws: bool = False) -> Task:
    """Return `task` with the limits of `settings` as further rules, or as it is.

    Designers are told the rules, and methods draw within them.

    Args:
        task: of the run.
        settings: of the run.
        draws: whether morphologies are drawn around the reference, within the search ranges.

    Raises:
        InputError: no scale of the reference's radii keeps the limits.
    """
    rules: list[Rule] = []
    if (most := settings.max_volume) is not None:
        rules.append(
            Rule(
                f"the volume of all parts together must be at most {most:g} m³",
                _above(lambda values: _volume(task, values), most, "volume", "m³"),
            )
        )
    if (most := settings.max_density) is not None:
        density = _density(task)
        rules.append(
            Rule(
                f"the mass divided by the volume must be at most {most:g} kg/m³",
                _above(density, most, "density", "kg/m³"),
            )
        )
    if not rules:
        return task
    searched = replace(task, rules=(*task.rules, *rules))
    if start(searched, drawn_around=draws) is None:
        ranges, remedy = "", "give larger ones"
        if draws and start(searched) is not None:
            ranges = " and the search ranges, within which morphologies are drawn"
            remedy += (
                ", or let a language model propose (--model, with a method that asks a designer), "
                "which is held to the task's bounds alone"
            )
        raise InputError(
            f"no scale of the radii brings the reference design of {task.id} within these limits"
            f"{ranges}: {'; '.join(rule.text for rule in rules)}; {remedy}"
        )
    return searched


def refusal(task: Task, morphology: Morphology) -> str:
    """Return why `task` refuses a morphology; nothing if it does not."""
    try:
        task.check(morphology.parameters)
    except InvalidMorphology as error:
        return str(error)
    return ""


def _above(
    measure: Callable[[Values], float | None], most: float, name: str, unit: str
) -> Callable[[Values], str | None]:
    def violation(values: Values) -> str | None:
        found = measure(values)
        if found is None or found <= most:
            return None
        return f"a {name} of {found:.4g} {unit} is above the limit of {most:g} {unit}"

    return violation


def _volume(task: Task, values: Values) -> float:
    return sum(shape.volume for shape in task.solids(values))


def _density(task: Task) -> Callable[[Values], float | None]:
    """Return a function from values to the density in kg/m³, as cheap as the robot allows.

    Most robots have one density, or one mass. Where probes show that, nothing is compiled later.
    """
    random = np.random.default_rng(0)
    space = UnitSpace(task)
    points = random.random((1000, space.size))
    values = [task.reference, *space.values(points)[space.valid(space.values(points))].tolist()]
    facts = [body_facts(task, tuple(one)) for one in values[: 1 + _PROBES]]
    for name in ("density", "mass"):
        first = facts[0][name]
        if all(abs(one[name] - first) <= 1e-6 * first for one in facts):
            if name == "density":
                return lambda values: first
            return lambda values: first / _volume(task, values)

    def compiled(values: Values) -> float | None:
        # What another rule refuses may not compile.
        if any(rule.violation(values) for rule in task.rules):
            return None
        return body_facts(task, tuple(values[name] for name in task.names))["density"]

    return compiled
