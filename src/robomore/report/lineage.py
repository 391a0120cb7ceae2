"""How a run got where it is: the grid's best, every improvement of every branch, the final."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from robomore.report.metrics import Spread, spread
from robomore.settings import SearchSettings
from robomore.types import Design, Evaluation, Place


@dataclass(frozen=True, slots=True)
class Step:
    """One step forward.

    Attributes:
        place: where it was measured.
        changed: what was new: `design` (the grid), `morphology`, `reward` or `training` (final).
        evaluation: what was measured; of the final, the first training seed.
        efficiency: over the training seeds (one, before the final), in m/m^3.
        fitness: likewise, in m.
        leads: whether the champion came this way.
    """

    place: Place
    changed: str
    evaluation: Evaluation
    efficiency: Spread
    fitness: Spread
    leads: bool


def in_order(placed: Iterable[tuple[Place, Evaluation]]) -> list[tuple[Place, Evaluation]]:
    """Return the evaluations in the order of the search, whatever order they were asked for in.

    A resumed run asks again from the start, so the ledger's own order may be half old, half new.
    """
    return sorted(placed, key=lambda pair: _rank(pair[0]))


def best_of(evaluations: Iterable[Evaluation], objective: str) -> Evaluation | None:
    """Return the best evaluation that succeeded; the first among equals."""
    best: Evaluation | None = None
    for evaluation in evaluations:
        if _better(evaluation, best, objective):
            best = evaluation
    return best


def way(
    placed: Sequence[tuple[Place, Evaluation]],
    settings: SearchSettings,
    winner: Sequence[Evaluation],
) -> tuple[Step, ...]:
    """Return the steps of all branches in order, and the final one.

    Args:
        placed: in the order of the search.
        settings: of the search.
        winner: final evaluations of the champion; empty while there is none.
    """
    objective = settings.objective
    grid = [(place, e) for place, e in placed if place.stage == "coarse" and e.ok]
    # As the search ranks them: best first, equals in the grid's order.
    grid.sort(key=lambda pair: -(pair[1].score(objective) or 0.0))
    branches = sorted({place.branch for place, _ in placed if place.stage == "fine"})
    steps: list[list[tuple[Place, str, Evaluation]]] = []
    # A branch of which nothing was measured (nobody had a proposal for it) has its start.
    for branch in range(max(branches, default=0) + 1):
        if branch >= len(grid):
            continue
        place, best = grid[branch]
        steps.append([(place, "design", best)])
        for place, evaluation in placed:
            mine = place.stage == "fine" and place.branch == branch
            if mine and _better(evaluation, best, objective):
                best = evaluation
                steps[-1].append((place, place.changed, evaluation))

    answer = winner[0].design if winner else None
    leading = max(
        steps,
        key=lambda path: (
            answer is not None and _same(path[-1][2].design, answer),
            path[-1][2].score(objective) or 0.0,
        ),
        default=None,
    )
    found = [
        Step(place, changed, e, spread([e.efficiency or 0.0]), spread([e.fitness or 0.0]), leads)
        for path in steps
        for leads in (path is leading,)
        for place, changed, e in path
    ]
    trained = [evaluation for evaluation in winner if evaluation.ok]
    if trained:
        first = next(
            place for place, e in placed if place.stage == "final" and e.key == trained[0].key
        )
        efficiency = spread([e.efficiency or 0.0 for e in trained])
        fitness = spread([e.fitness or 0.0 for e in trained])
        found.append(Step(first, "training", trained[0], efficiency, fitness, True))
    return tuple(found)


def _rank(place: Place) -> tuple[int, ...]:
    if place.stage == "screening":
        return (-1, place.morphology)
    if place.stage == "coarse":
        return (0, place.morphology, place.reward)
    if place.stage == "fine":
        return (1, place.cycle, int(place.changed == "reward"), place.branch)
    return (2, int(place.changed == "human"), place.branch, place.repeat)


def _better(new: Evaluation, old: Evaluation | None, objective: str) -> bool:
    score = new.score(objective)
    if score is None:
        return False
    former = old.score(objective) if old else None
    return former is None or score > former


def _same(one: Design, other: Design) -> bool:
    return (one.morphology.parameters, one.reward.source) == (
        other.morphology.parameters,
        other.reward.source,
    )
