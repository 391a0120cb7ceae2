"""The last word: the best designs and the reference, trained anew alike over several seeds.

The best of many noisy numbers is too good to be true. What a run reports is therefore measured
anew: same budget, same seeds, fresh training (paper, App. "Policy Training"). And the pairs are
crossed: the found morphology under the reference reward, and the reference morphology under the
found reward, so that it can be seen which of the two made the difference. The best pair of them
all is the champion, whoever proposed it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import fmean

from robomore.plan import Stage
from robomore.search.measure import Evaluate
from robomore.settings import FinalSettings
from robomore.types import Design, Evaluation, Morphology, Place, Trial

STAGE = "final"

FOUND, REFERENCE = "found", "reference"
MORPHOLOGY_ONLY, REWARD_ONLY = (
    "found morphology, reference reward",
    "reference morphology, found reward",
)

Group = tuple[Evaluation, ...]
"""Evaluations of one design, one for each training seed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Final:
    """Evaluations of the designs in the final, one for each training seed.

    Attributes:
        champion: the best of all the groups below.
        found: the finalist with the best mean score.
        reference: the reference design.
        morphology_only: the found morphology under the reference reward.
        reward_only: the reference morphology under the found reward.
    """

    champion: Group
    found: Group
    reference: Group
    morphology_only: Group
    reward_only: Group


def stage(settings: FinalSettings) -> Stage:
    """Return what the final asks for: finalists, reference, and the two crossed pairs."""
    count = (settings.finalists + 3) * settings.seeds
    return Stage(
        name=STAGE,
        axes=("finalist",),
        shape=(settings.finalists,),
        evaluations=count,
        steps=count * settings.steps,
        batches=1 if settings.finalists == 1 else 2,
        role="final",
    )


def final(
    evaluate: Evaluate,
    finalists: Sequence[Evaluation],
    reference: Design,
    seeds: int,
    objective: str,
    eligible: Callable[[Morphology], bool] = lambda morphology: True,
) -> Final:
    """Train `finalists`, `reference` and the crossed pairs anew, and name the champion.

    A design that trained on more seeds goes before one that failed on some; among equals the mean
    score decides, and then the order finalists, crossed pairs, reference.

    Args:
        evaluate: measures a batch at the final's budget.
        finalists: the search's best, best first.
        reference: the reference morphology under the reference reward.
        seeds: training seeds of each design.
        objective: what is compared.
        eligible: whether a morphology may be champion; the reference may break the run's limits.
    """

    def trials(role: str, design: Design, index: int = 0, parent: str = "") -> list[Trial]:
        return [
            Trial(
                design,
                Place(stage=STAGE, index=(index,), changed=role, parent=parent, repeat=repeat),
            )
            for repeat in range(1, seeds + 1)
        ]

    def crossed(best: Evaluation) -> list[Trial]:
        found = best.design
        return [
            *trials(MORPHOLOGY_ONLY, Design(found.morphology, reference.reward), parent=best.key),
            *trials(REWARD_ONLY, Design(reference.morphology, found.reward), parent=best.key),
        ]

    asked = [
        trial
        for index, one in enumerate(finalists)
        for trial in trials(FOUND, one.design, index, one.key)
    ]
    asked += trials(REFERENCE, reference)
    if len(finalists) == 1:
        # Nobody has to be waited for, so that the workers are kept busy.
        *groups, with_reference, morphology_only, reward_only = _by_design(
            evaluate([*asked, *crossed(finalists[0])]), seeds
        )
        found = groups[0]
    else:
        *groups, with_reference = _by_design(evaluate(asked), seeds)
        found = max(groups, key=lambda group: standing(group, objective))
        best = finalists[groups.index(found)]
        morphology_only, reward_only = _by_design(evaluate(crossed(best)), seeds)
    groups = [found, morphology_only, reward_only, with_reference]
    return Final(
        champion=max(
            (group for group in groups if eligible(group[0].design.morphology)),
            key=lambda group: standing(group, objective),
        ),
        found=found,
        reference=with_reference,
        morphology_only=morphology_only,
        reward_only=reward_only,
    )


def standing(group: Group, objective: str) -> tuple[int, float]:
    """Return what groups are compared by: seeds that trained, then their mean score."""
    scores = [score for e in group if (score := e.score(objective)) is not None]
    return len(scores), fmean(scores) if scores else 0.0


def _by_design(measured: Sequence[Evaluation], seeds: int) -> list[Group]:
    return [tuple(measured[i : i + seeds]) for i in range(0, len(measured), seeds)]
