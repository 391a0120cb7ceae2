"""The last word: the best designs and the reference, trained anew alike over several seeds.

The best of many noisy numbers is too good to be true. What a run reports is therefore measured
anew: same budget, as many seeds, fresh training (paper, App. "Policy Training"). And the pairs are
crossed: the found morphology under the reference reward, and the reference morphology under the
found reward, so that it can be seen which of the two made the difference. The best pair of them
all is the champion, whoever proposed it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import fmean

from robomore.plan import Stage
from robomore.search.measure import Evaluate, content
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
        champion: the best of all the groups below that nothing is said against.
        found: the finalist with the best mean score, of those that nothing is said against.
        reference: the reference design.
        morphology_only: the found morphology under the reference reward.
        reward_only: the reference morphology under the found reward.
        places: all that were asked for, those of other finalists among them.
    """

    champion: Group
    found: Group
    reference: Group
    morphology_only: Group
    reward_only: Group
    places: tuple[Place, ...]
    passed_over: tuple[tuple[Group, str], ...] = ()
    """Groups that would have had the seat of `champion` or `found`, and what is said against."""


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
    doubt: Callable[[Group], str] = lambda group: "",
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
        doubt: says what speaks against a group that is about to be chosen, or nothing. The
            reference design is chosen all the same: it is what the others are compared with.
    """
    doubts: dict[Design, str] = {}

    def first_sound(groups: Sequence[Group]) -> Group | None:
        for group in sorted(groups, key=lambda one: standing(one, objective), reverse=True):
            design = group[0].design
            if same_content(design, reference):
                return group
            if not standing(group, objective)[0]:
                continue
            if design not in doubts:
                doubts[design] = doubt(group)
                if doubts[design]:
                    passed_over.append((group, doubts[design]))
            if not doubts[design]:
                return group
        return None

    passed_over: list[tuple[Group, str]] = []

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
        asked += crossed(finalists[0])
        *groups, with_reference, morphology_only, reward_only = _by_design(evaluate(asked), seeds)
        found = groups[0]
    else:
        *groups, with_reference = _by_design(evaluate(asked), seeds)
        best_group = max(groups, key=lambda group: standing(group, objective))
        found = first_sound(groups) or best_group
        pairs = crossed(finalists[groups.index(found)])
        morphology_only, reward_only = _by_design(evaluate(pairs), seeds)
        asked += pairs
    groups = [found, morphology_only, reward_only, with_reference]
    allowed = [group for group in groups if eligible(group[0].design.morphology)]
    return Final(
        # The reference has a seat where all others are passed over, whatever the run's limits.
        champion=first_sound(allowed) or with_reference,
        found=found,
        reference=with_reference,
        morphology_only=morphology_only,
        reward_only=reward_only,
        places=tuple(trial.place for trial in asked),
        passed_over=tuple(passed_over),
    )


def standing(group: Group, objective: str) -> tuple[int, float]:
    """Return what groups are compared by: seeds that trained, then their mean score."""
    scores = [score for e in group if (score := e.score(objective)) is not None]
    return len(scores), fmean(scores) if scores else 0.0


def same_content(one: Design, other: Design) -> bool:
    """Return whether two designs are the same but for their ideas."""
    return content(one) == content(other)


def _by_design(measured: Sequence[Evaluation], seeds: int) -> list[Group]:
    return [tuple(measured[i : i + seeds]) for i in range(0, len(measured), seeds)]
