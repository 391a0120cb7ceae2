"""No search at all: the reference design as it is, so that every method has it to beat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from robomore.designers.designer import Designer
from robomore.plan import Plan, Stage
from robomore.search.measure import Evaluate, ranked
from robomore.search.method import SearchContext
from robomore.types import Evaluation, Place, Trial

STAGE = "reference"


@dataclass(frozen=True, slots=True)
class ReferenceSettings:
    """The method `reference` has no options."""


class ReferenceOnly:
    """Trains the reference design and nothing else (the paper's "Human" row)."""

    Settings = ReferenceSettings
    summary: ClassVar[str] = "no search: the reference design as it is"
    needs_designer: ClassVar[bool] = False
    provenance: ClassVar[str] = "Nothing was searched: this is the reference design as it is."

    def __init__(self, settings: ReferenceSettings) -> None:
        self.settings = settings

    def plan(self, context: SearchContext) -> Plan:
        """Return one stage of one evaluation."""
        return Plan((Stage(name=STAGE, evaluations=1, steps=context.candidate.steps),))

    def run(
        self, designer: Designer, evaluate: Evaluate, context: SearchContext
    ) -> list[Evaluation]:
        """Return the reference design's evaluation; `designer` is not asked."""
        return ranked(evaluate([Trial(context.reference, Place(stage=STAGE))]), context.objective)
