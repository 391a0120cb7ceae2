"""Eureka's loop for morphologies: the other half of the search, under the reference reward."""

from __future__ import annotations

from typing import ClassVar

from robomore.designers.designer import Designer
from robomore.plan import Plan
from robomore.search.eureka import EurekaSettings, iterated, planned
from robomore.search.measure import Evaluate
from robomore.search.method import SearchContext
from robomore.search.starts import Kind
from robomore.types import Design, Evaluation, Morphology, Slot


class EurekaMorphology:
    """Morphologies under the reference reward (the paper's "Eureka (Morphology)")."""

    Settings = EurekaSettings
    summary: ClassVar[str] = "Eureka's loop for morphologies, under the reference reward"
    needs_designer: ClassVar[bool] = True
    starts_from: ClassVar[tuple[Kind, ...]] = ("morphology",)
    provenance: ClassVar[str] = ""

    def __init__(self, settings: EurekaSettings) -> None:
        self.settings = settings

    def plan(self, context: SearchContext) -> Plan:
        """Return one stage of so many rounds."""
        return planned(self.settings, "morphology", context)

    def run(
        self, designer: Designer, evaluate: Evaluate, context: SearchContext
    ) -> list[Evaluation]:
        """Return the trained designs, best first.

        Raises:
            NothingTrained: no morphology was proposed in the first round, or none trained in any.
        """

        def designed(morphology: Morphology) -> Design:
            return Design(morphology, context.reference.reward)

        def first(slot: Slot) -> Morphology:
            return designer.propose_morphology(slot, ())

        return iterated(
            self.settings,
            "morphology",
            first,
            designer.improve_morphology,
            designed,
            evaluate,
            context,
        )
