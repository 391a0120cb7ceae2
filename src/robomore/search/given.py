"""No search: one design that is given, trained anew beside the reference design."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from robomore.designers.designer import Designer
from robomore.plan import Plan, Stage
from robomore.search.measure import Evaluate, ranked
from robomore.search.method import SearchContext
from robomore.types import Design, Evaluation, Morphology, Place, Reward, Trial

STAGE = "given"


@dataclass(frozen=True, slots=True)
class GivenSettings:
    """Options of the method `given`."""

    parameters: list[float] | None = None
    """Of the morphology, in the task's order; `null`: the reference morphology."""
    reward: str | None = None
    """Text of the reward; `null`: the reference reward."""


class Given:
    """Trains one design and no other, so that the final crosses it with the reference design."""

    Settings = GivenSettings
    summary: ClassVar[str] = "no search: one design that is given, such as a champion elsewhere"
    needs_designer: ClassVar[bool] = False
    provenance: ClassVar[str] = "Nothing was searched: the design was given."

    def __init__(self, settings: GivenSettings) -> None:
        self.settings = settings

    def plan(self, context: SearchContext) -> Plan:
        """Return one stage of one evaluation.

        Raises:
            InvalidMorphology: the task refuses the parameters.
        """
        self._design(context)  # refused before anything runs, and not as a failure of training
        return Plan((Stage(name=STAGE, evaluations=1, steps=context.candidate.steps),))

    def run(
        self, designer: Designer, evaluate: Evaluate, context: SearchContext
    ) -> list[Evaluation]:
        """Return the given design's evaluation; `designer` is not asked."""
        trial = Trial(self._design(context), Place(stage=STAGE))
        return ranked(evaluate([trial]), context.objective)

    def _design(self, context: SearchContext) -> Design:
        """Return what was given, and the reference's in place of what was not."""
        given, reference = self.settings, context.reference
        morphology, reward = reference.morphology, reference.reward
        if given.parameters is not None:
            morphology = Morphology(context.task.check(given.parameters), "given")
        if given.reward is not None:
            reward = Reward(given.reward, "given")
        return Design(morphology, reward)
