"""Eureka (Ma et al. 2024): rewards for the reference morphology, sampled and reflected upon.

An iteration samples several rewards side by side. The best of them, with the statistics of its
terms over training, is what the next iteration's rewards improve on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, ClassVar, TypeVar

import msgspec

from robomore.designers.designer import Designer
from robomore.errors import NothingTrained
from robomore.plan import Plan, Stage
from robomore.search.measure import Evaluate, ranked, top
from robomore.search.method import SearchContext
from robomore.search.population import kept_morphology
from robomore.search.propose import filled, independent
from robomore.search.starts import Kind
from robomore.types import Design, Evaluation, Place, Reward, Slot, Trial

STAGE = "iterations"

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class EurekaSettings:
    """Options of the methods `eureka` and `eureka-morphology`."""

    iterations: Annotated[int, msgspec.Meta(ge=1)] = 5
    """Rounds of sampling, each but the first with a reflection on the round before."""
    samples: Annotated[int, msgspec.Meta(ge=1)] | None = None
    """Proposals in each round, 16 in the paper of Eureka; by default as many as give about the
    full trainings of the preset's search in all."""


class Eureka:
    """Rewards for the reference morphology; proposals of a round do not know of each other."""

    Settings = EurekaSettings
    summary: ClassVar[str] = "Eureka: rewards for the reference morphology, improved in rounds"
    needs_designer: ClassVar[bool] = True
    starts_from: ClassVar[tuple[Kind, ...]] = ("reward",)
    provenance: ClassVar[str] = ""

    def __init__(self, settings: EurekaSettings) -> None:
        self.settings = settings

    def plan(self, context: SearchContext) -> Plan:
        """Return one stage of so many rounds."""
        return planned(self.settings, "reward", context)

    def run(
        self, designer: Designer, evaluate: Evaluate, context: SearchContext
    ) -> list[Evaluation]:
        """Return the trained designs, best first.

        Raises:
            NothingTrained: no reward was proposed in the first round, or none trained in any.
        """

        morphology = kept_morphology(context)

        def designed(reward: Reward) -> Design:
            return Design(morphology, reward)

        def first(slot: Slot) -> Reward:
            return designer.propose_reward(slot, ())

        return iterated(
            self.settings, "reward", first, designer.improve_reward, designed, evaluate, context
        )


def planned(settings: EurekaSettings, kind: Kind, context: SearchContext) -> Plan:
    """Return one stage of so many rounds of proposals of one kind."""
    rounds, samples = settings.iterations, sample_count(settings, context)
    count = rounds * samples
    return Plan(
        (
            Stage(
                name=STAGE,
                axes=("iteration", "sample"),
                shape=(rounds, samples),
                proposals=(("propose", kind, samples), ("improve", kind, count - samples)),
                evaluations=count,
                steps=count * context.candidate.steps,
                batches=rounds,
            ),
        )
    )


def iterated(
    settings: EurekaSettings,
    kind: Kind,
    propose: Callable[[Slot], T],
    improve: Callable[[Slot, Evaluation, Sequence[Evaluation]], T],
    designed: Callable[[T], Design],
    evaluate: Evaluate,
    context: SearchContext,
) -> list[Evaluation]:
    """Return the trained designs of all rounds, best first (Ma et al. 2024, Alg. 1).

    Args:
        settings: rounds and samples.
        kind: what is proposed.
        propose: asks for a first proposal.
        improve: asks for a proposal that improves on an evaluation.
        designed: puts a proposal together with what stays as it is.
        evaluate: measures a batch.
        context: of the search.

    Raises:
        NothingTrained: nothing was proposed in the first round, or nothing trained in any.
    """
    samples = sample_count(settings, context)
    found: list[Evaluation] = []
    best: Evaluation | None = None
    for number in range(settings.iterations):
        # While nothing has trained, there is nothing to reflect on: the first round goes on.
        slots = [
            Slot(STAGE, kind, (number, n), improves=True)
            if best
            else Slot(STAGE, kind, (0, number * samples + n))
            for n in range(samples)
        ]
        # As in Eureka, a round knows the best of the round before, and nothing else.
        asks = [
            partial(propose, slot) if best is None else partial(improve, slot, best, (best,))
            for slot in slots
        ]
        try:
            proposals = filled(independent(asks, context.map_fn), kind)
        except NothingTrained:
            if not found:
                raise
            continue
        places = [
            Place(
                stage=STAGE,
                index=(number, n),
                changed=kind if best else "",
                parent=best.key if best else "",
            )
            for n in proposals
        ]
        designs = map(designed, proposals.values())
        measured = evaluate([Trial(*one) for one in zip(designs, places, strict=True)])
        found += measured
        best = next(iter(ranked(measured, context.objective)), best)
    return top(found, 1.0, context.objective)


def sample_count(settings: EurekaSettings, context: SearchContext) -> int:
    """Return how many proposals a round has."""
    return settings.samples or max(1, round(context.evaluations / settings.iterations))
