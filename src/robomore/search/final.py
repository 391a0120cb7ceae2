"""The last word: the best designs and the human one, retrained alike over several seeds.

The best of many noisy numbers is too good to be true. What a run reports is therefore measured
anew: same budget, same seeds, fresh training for the finalists and for the human design (paper,
App. "Policy Training": the winner is retrained).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

from robomore.search.measure import Evaluate
from robomore.types import Design, Evaluation, Place, Trial


@dataclass(frozen=True, slots=True)
class Final:
    """Retrained evaluations, one for each training seed.

    Attributes:
        champion: of the finalist with the best mean score.
        human: of the human design.
    """

    champion: tuple[Evaluation, ...]
    human: tuple[Evaluation, ...]


def final(
    evaluate: Evaluate,
    finalists: Sequence[Design],
    human: Design,
    repeats: int,
    objective: str,
) -> Final:
    """Retrain `finalists` and `human`, `repeats` seeds each, and name the champion.

    A finalist that trained on more seeds goes before one that failed on some; among equals the mean
    score decides.
    """
    contestants = [("champion", index, design) for index, design in enumerate(finalists)]
    contestants.append(("human", 0, human))
    trials = [
        Trial(design, Place(stage="final", changed=role, branch=index, repeat=repeat))
        for role, index, design in contestants
        for repeat in range(1, repeats + 1)
    ]
    measured = evaluate(trials)
    groups = [tuple(measured[i : i + repeats]) for i in range(0, len(measured), repeats)]
    champion = max(groups[:-1], key=lambda group: _standing(group, objective))
    return Final(champion=champion, human=groups[-1])


def _standing(group: Sequence[Evaluation], objective: str) -> tuple[int, float]:
    scores = [score for e in group if (score := e.score(objective)) is not None]
    return len(scores), fmean(scores) if scores else 0.0
