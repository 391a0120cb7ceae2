"""How much the paper's search may ask for, from its sizes."""

from __future__ import annotations

from itertools import pairwise

from robomore.plan import Plan, Stage
from robomore.search.measure import survivor_count
from robomore.search.robomore.settings import RoboMoReSettings
from robomore.settings import Budget

COARSE, FINE = "coarse", "fine"

_TYPICAL_CYCLES, _TYPICAL_ADAPTIVE_CYCLES = 2.0, 2.5
"""Cycles after which most branches have stopped improving. With adaptive turns one more may pass
until both kinds were tried on the best."""


def planned(settings: RoboMoReSettings, candidate: Budget) -> Plan:
    """Return the stages of the search with the most that each may ask for."""
    pairs = settings.morphologies * settings.rewards
    trainings, batches = _coarse_trainings(settings)
    branches = survivor_count(settings.survivors, pairs)
    cycles = settings.max_cycles
    trials, fine_batches = 2 * branches * cycles, 2 * cycles
    adaptive = settings.order == "adaptive"
    turns = 2 * cycles if adaptive else cycles
    typical = _TYPICAL_ADAPTIVE_CYCLES if adaptive else _TYPICAL_CYCLES
    first_look = settings.rungs[0].budget_fraction if batches > 1 else 0
    if settings.improvement == "seeds" and cycles:
        # Each proposal is measured twice at most, and so is what a branch begins with.
        trials, fine_batches = 2 * trials + branches, 2 * fine_batches
    return Plan(
        (
            Stage(
                name=COARSE,
                axes=("morphology", "reward"),
                shape=(settings.morphologies, settings.rewards),
                proposals=(
                    # The one row without it is the reference's, and no designer is asked.
                    (
                        "propose",
                        "morphology",
                        0 if "morphology" in settings.without else settings.proposed_morphologies,
                    ),
                    ("propose", "reward", settings.proposed_rewards),
                ),
                evaluations=pairs,
                steps=round(trainings * candidate.steps),
                batches=batches,
                shortest=round(first_look * candidate.steps),
            ),
            Stage(
                name=FINE,
                axes=("branch", "turn" if adaptive else "cycle"),
                shape=(branches, turns),
                # With adaptive turns it may be more of one and fewer of the other.
                proposals=(
                    ("improve", "morphology", branches * cycles),
                    ("improve", "reward", branches * cycles),
                ),
                evaluations=trials,
                steps=trials * candidate.steps,
                batches=fine_batches,
                typical=min(1.0, typical / max(1, cycles)),
            ),
        )
    )


def _coarse_trainings(settings: RoboMoReSettings) -> tuple[float, int]:
    """Return how many full trainings the grid amounts to, and in how many batches they come."""
    pairs = settings.morphologies * settings.rewards
    if settings.screening == "none" or not settings.rungs:
        return pairs, 1
    trainings = pairs * settings.rungs[0].budget_fraction
    ends = [*(rung.budget_fraction for rung in settings.rungs), 1.0]
    for rung, (begin, end) in zip(settings.rungs, pairwise(ends), strict=True):
        trainings += survivor_count(rung.keep_fraction, pairs) * (end - begin)
    return trainings, len(settings.rungs) + 1
