"""The reference design made thinner: one number, so that every method has a fair baseline.

Efficiency is fitness over volume, and volume falls with the square of a radius. So a thinner
reference design is the first thing to beat: no search, and no idea beyond one scale.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import msgspec
import numpy as np

from robomore.designers.designer import Designer
from robomore.errors import InputError, InvalidMorphology
from robomore.plan import Plan, Stage
from robomore.search.measure import Evaluate, ranked
from robomore.search.method import SearchContext
from robomore.search.population import start
from robomore.tasks.task import Task
from robomore.tasks.unit_space import DECIMALS, UnitSpace
from robomore.types import Design, Evaluation, Morphology, Place, Trial

STAGE = "scales"

_TRIED = 200
"""Scales between the thinnest one within the bounds and 1, of which the first valid one is the
thinnest that is used."""

_REMEDY = "leave --method-option thinnest out, or choose another --method"


@dataclass(frozen=True, slots=True)
class SlimReferenceSettings:
    """Options of the method `slim-reference`."""

    values: Annotated[int, msgspec.Meta(ge=1, le=100)] = 6
    """How many scales are tried, from the thinnest up. Each is thicker than the one before by the
    same factor; the next one after the thickest would be the reference itself."""
    thinnest: Annotated[float, msgspec.Meta(gt=0, lt=1)] | None = None
    """The smallest scale of the radii, within the task's own bounds and rules; by default the
    smallest that its search ranges and search rules allow, to which methods that draw keep."""


class SlimReference:
    """Scales all radii of the reference morphology by one number, under the reference reward."""

    Settings = SlimReferenceSettings
    summary: ClassVar[str] = "the reference design with all radii scaled down by one number"
    needs_designer: ClassVar[bool] = False
    provenance: ClassVar[str] = (
        "No LLM was used: the radii of the reference design were scaled by one number, and nothing "
        "else was changed."
    )

    def __init__(self, settings: SlimReferenceSettings) -> None:
        self.settings = settings

    def plan(self, context: SearchContext) -> Plan:
        """Return one stage with an evaluation for each scale.

        Raises:
            InputError: the task has no radii that could be scaled down, or not so far.
        """
        count = len(slim(context.task, self.settings))
        steps = count * context.candidate.steps
        return Plan(
            (Stage(name=STAGE, axes=("scale",), shape=(count,), evaluations=count, steps=steps),)
        )

    def run(
        self, designer: Designer, evaluate: Evaluate, context: SearchContext
    ) -> list[Evaluation]:
        """Return the trained designs, best first; `designer` is not asked."""
        morphologies = slim(context.task, self.settings)
        trials = [
            Trial(Design(one, context.reference.reward), Place(stage=STAGE, index=(n,)))
            for n, one in enumerate(morphologies)
        ]
        return ranked(evaluate(trials), context.objective)


def thinnest(task: Task) -> Morphology:
    """Return the reference morphology with its radii at the smallest scale that the task allows, or
    where no radius could be smaller, as near to what it is as a run's limits allow."""
    try:
        return slim(task, SlimReferenceSettings())[0]
    except InputError:
        begin = start(task)
    if begin is None or begin == task.reference:
        return Morphology(task.reference, "the reference, whose radii cannot be scaled down")
    return Morphology(begin, "the reference with its radii scaled into the run's limits")


def slim(task: Task, settings: SlimReferenceSettings) -> list[Morphology]:
    """Return the reference morphology at each scale of its radii, the thinnest first.

    Scales beyond a run's limits are left out.

    Raises:
        InputError: no parameter sets a radius, or the wanted scales break bounds, rules or limits.
    """
    radii, reference = UnitSpace(task).radii, np.array(task.reference)
    within = "bounds and rules"
    if settings.thinnest is None:
        task, within = task.searched(), "search ranges and search rules"
    if not radii.any():
        raise InputError(
            f"no parameter of {task.id} sets a radius, so slim-reference has nothing to scale; "
            "choose another --method"
        )

    def at(scale: float) -> list[float]:
        scaled: list[float] = np.where(
            radii, np.round(scale * reference, DECIMALS), reference
        ).tolist()
        return scaled

    def valid(scale: float) -> tuple[float, ...] | None:
        try:
            return task.check(at(scale))
        except InvalidMorphology:
            return None

    # Rounding must not push the thinnest radius below its bound.
    low = np.array([parameter.low for parameter in task.parameters])
    bound = float((low[radii] / reference[radii]).max()) + 10.0**-DECIMALS
    tried = np.geomspace(min(bound, 1.0), 1.0, _TRIED).tolist()
    least = next((scale for scale in tried if valid(scale)), 1.0)
    thinnest = settings.thinnest or least
    if thinnest >= 1:
        raise InputError(
            f"no radii of {task.id} thinner than the reference's are within its {within} and this "
            "run's limits; choose another --method"
        )
    if thinnest < least and not valid(thinnest):
        raise InputError(
            f"the radii of {task.id} cannot be scaled by {thinnest:.4g}: its {within} allow "
            f"{least:.4g} at the least; {_REMEDY}"
        )
    scales = [thinnest ** (1 - n / settings.values) for n in range(settings.values)]
    found = {values: scale for scale in scales if (values := valid(scale))}
    if not found:
        try:
            task.check(at(thinnest))
        except InvalidMorphology as error:
            raise InputError(
                f"none of the {settings.values} scales from {thinnest:.4g} up is valid ({error}); "
                f"{_REMEDY}"
            ) from None
    return [
        Morphology(values, f"the reference with all radii scaled by {scale:.3g}")
        for values, scale in found.items()
    ]
