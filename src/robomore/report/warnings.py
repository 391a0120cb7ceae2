"""What a reader should keep in mind before believing a champion, found from the numbers alone."""

from __future__ import annotations

from collections.abc import Sequence

from robomore.report.empty import EmptySlot
from robomore.report.finalists import Contestant
from robomore.report.words import EFFICIENCY_UNIT, number
from robomore.settings import SearchSettings
from robomore.store import Manifest
from robomore.tasks import Task
from robomore.types import Evaluation

FEWEST_SEEDS = 3
"""With fewer training seeds a spread is hardly known."""

STEEL = 7850.0
"""Density of steel in kg/m^3: a robot as a whole is never denser."""

_AT_BOUND = 0.01
"""A parameter counts as at its bound within this share of its range."""
_NAMED = 3
"""Empty slots that are named."""
_WINNERS_CURSE = 0.7
"""Retrained below this share of what the search saw, the search was lucky."""


def cautions(
    manifest: Manifest,
    task: Task,
    champion: Contestant | None,
    human: Contestant | None,
    final: bool,
    found: Evaluation | None,
    empty: Sequence[EmptySlot] = (),
) -> tuple[str, ...]:
    """Return one sentence for each reason to doubt, the most important first.

    Args:
        manifest: of the run.
        task: of the run.
        champion: or the best so far.
        human: as measured in the final.
        final: whether the champion was retrained.
        found: the best evaluation of the search, before any retraining.
        empty: slots that the designer could not fill.
    """
    said: list[str] = []
    if champion is None:
        return ("Nothing has been trained successfully yet.", *_about_slots(empty))
    if not final:
        said.append(
            "The run is not finished: this is the best so far, measured once, and not yet "
            "retrained next to the human design."
        )
    if manifest.preset == "smoke":
        said.append("The smoke preset checks that everything runs; its budget trains nothing.")
    said += _about_slots(empty)
    if final:
        said += _about_seeds(champion, human)
        said += _about_retraining(manifest.settings.search, champion, found)
        said += _about_fitness(champion, human)
    said += _about_matter(champion)
    said += _about_bounds(task, champion)
    if manifest.task_version != task.version:
        said.append(
            f"The run used version {manifest.task_version} of the task, installed is version "
            f"{task.version}: drawings and bounds may differ from what was trained."
        )
    return tuple(said)


def _about_slots(empty: Sequence[EmptySlot]) -> list[str]:
    if not empty:
        return []
    named = "; ".join(str(one.slot) for one in empty[:_NAMED])
    more = f" and {len(empty) - _NAMED} more" if len(empty) > _NAMED else ""
    return [
        f"{len(empty)} slot{'s' if len(empty) != 1 else ''} stayed empty, because the designer had "
        f"no proposal that could be used ({named}{more}): less was tried than was asked for."
    ]


def _about_seeds(champion: Contestant, human: Contestant | None) -> list[str]:
    said = []
    for one in (champion, human):
        if one is None:
            continue
        failed = len(one.evaluations) - len(one.trained)
        if failed:
            said.append(
                f"{failed} of {len(one.evaluations)} final trainings of the {one.name} design "
                f"failed ({one.evaluations[-1].status if failed == 1 else 'see failures'})."
            )
    seeds = len(champion.trained)
    if seeds < FEWEST_SEEDS:
        said.append(
            f"Only {seeds} training seed{'s' if seeds != 1 else ''} in the final: with fewer than "
            f"{FEWEST_SEEDS} the spread is hardly known."
        )
    return said


def _about_retraining(
    search: SearchSettings, champion: Contestant, found: Evaluation | None
) -> list[str]:
    measured = champion.efficiency if search.objective == "efficiency" else champion.fitness
    seen = found.score(search.objective) if found else None
    if measured is None or not seen or measured.mean >= _WINNERS_CURSE * seen:
        return []
    unit = EFFICIENCY_UNIT if search.objective == "efficiency" else "m"
    return [
        f"The search saw {number(seen)} {unit}, retraining gave {number(measured.mean)}: the best "
        "of many noisy numbers is partly luck."
    ]


def _about_fitness(champion: Contestant, human: Contestant | None) -> list[str]:
    if champion.fitness is None or human is None or human.fitness is None:
        return []
    said = []
    if champion.fitness.mean < human.fitness.mean:
        said.append(
            f"The champion is the lighter robot, not the better runner: its fitness is "
            f"{number(champion.fitness.mean)} m against {number(human.fitness.mean)} m of the "
            "human design; its efficiency comes from the small volume."
        )
    if human.fitness.mean <= 0:
        said.append(
            "The human design did not move forward at this budget, so no ratio is given; train "
            "longer for a fair comparison."
        )
    return said


def _about_matter(champion: Contestant) -> list[str]:
    density = champion.body.get("density", 0.0)
    if density <= STEEL:
        return []
    return [
        f"Implied density {number(density, 3)} kg/m³ (steel has {number(STEEL)}): the task fixes "
        "the mass, so a body this thin would have to be made of impossibly dense matter."
    ]


def _about_bounds(task: Task, champion: Contestant) -> list[str]:
    at_bound = []
    for parameter in task.parameters:
        value = champion.parameters[parameter.name]
        near = _AT_BOUND * (parameter.high - parameter.low)
        if parameter.scale == "log":
            near = _AT_BOUND * value
        if min(abs(value - parameter.low), abs(value - parameter.high)) <= near:
            at_bound.append(parameter.name)
    if not at_bound:
        return []
    verb = "stands at its bound" if len(at_bound) == 1 else "stand at their bounds"
    return [f"{', '.join(at_bound)} {verb}: the bounds decided part of this design."]
