"""What a reader should keep in mind before believing a champion, found from the numbers alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from robomore.runs.bounds import at_bounds
from robomore.runs.lineage import best_of
from robomore.runs.slimmed import slim_scale
from robomore.runs.words import in_unit, number
from robomore.statistics.spread import FEWEST

if TYPE_CHECKING:
    from robomore.runs.run import Run
    from robomore.runs.trained import TrainedDesign

STEEL = 7850.0
"""Density of steel in kg/m³: a robot as a whole is never denser."""

_NAMED = 3
"""Empty slots that are named."""
_WINNERS_CURSE = 0.7
"""Trained anew below this share of what the search saw, the search was lucky; after a longer
training all the more, so that nothing is said of luck which the longer training makes up for."""


def warnings_about(run: Run) -> tuple[str, ...]:
    """Return one sentence for each reason to doubt, the most important first."""
    said: list[str] = []
    if run.task_changes:
        said.append(
            f"The task {run.task.id} was edited after this run ({', '.join(run.task_changes)}): "
            "drawings, bounds and volumes shown here may not be those of the run."
        )
    if run.containment:
        said.append(
            f"Containment was {run.containment}. Where files or system calls are not kept in, a "
            "reward from elsewhere could have changed these numbers."
        )
    champion = run.champion
    if champion is None:
        return (*said, "Nothing has been trained successfully yet.", *_about_slots(run))
    if run.focus:
        said.append("This is one evaluation of the run, and not its champion.")
    elif not run.final:
        said.append(
            "The run is not finished: this is the best so far, measured once, and not yet trained "
            "anew beside the reference design."
        )
    if run.is_smoke:
        said.append("The smoke preset only checks that everything runs; its budget trains nothing.")
    said += _about_slots(run)
    if run.final:
        said += _about_seeds(run)
        if run.pairs is not None and run.pairs.doubt:
            said.append(run.pairs.verdict)
        said += _about_training_anew(run)
        said += _about_fitness(run)
        said += _about_height(run)
        said += _about_limits(run)
        said += _about_audits(run)
    said += _about_slimness(run, champion)
    said += _about_matter(champion)
    said += _about_bounds(run, champion)
    if run.task.mass:
        said.append(f"How mass follows from size is declared by the task: {run.task.mass}.")
    return tuple(said)


def _about_slots(run: Run) -> list[str]:
    empty = run.empty
    if not empty:
        return []
    named = "; ".join(str(one.slot) for one in empty[:_NAMED])
    more = f" and {len(empty) - _NAMED} more" if len(empty) > _NAMED else ""
    return [
        f"{len(empty)} slot{'s' if len(empty) != 1 else ''} stayed empty, because the designer had "
        f"no proposal that could be used ({named}{more}): less was tried than was asked for."
    ]


def _about_seeds(run: Run) -> list[str]:
    said = []
    for one in (run.champion, run.reference):
        if one is None:
            continue
        failed = [e for e in one.evaluations if not e.ok]
        if failed:
            said.append(
                f"{len(failed)} of {len(one.evaluations)} final trainings of the {one.name} design "
                f"failed ({failed[0].status})."
            )
    seeds = len(run.champion.trained) if run.champion else 0
    if seeds < FEWEST:
        said.append(
            f"Only {seeds} training seed{'s' if seeds != 1 else ''} in the final: with fewer than "
            f"{FEWEST} there is no interval, and a difference may be luck."
        )
    return said


def _about_training_anew(run: Run) -> list[str]:
    best = best_of((record.evaluation for record in run.searched), run.objective)
    measured = run.found.score(run.objective) if run.found else None
    seen = best.score(run.objective) if best else None
    if measured is None or not seen or seen < 0 or measured.mean >= _WINNERS_CURSE * seen:
        return []
    settings = run.manifest.settings
    search, final = settings.candidate.steps, settings.final.steps
    saw = f"The search saw {in_unit(seen, run.objective, run.fitness_unit)}"
    anew = f"training anew gave {number(measured.mean)}"
    luck = "the best of many noisy numbers is partly luck"
    if final == search:
        return [f"{saw}, {anew}, both after {search:,} control steps: {luck}."]
    other = (
        "part of that luck is hidden by the longer training"
        if final > search
        else "the shorter training may be the other part"
    )
    return [f"{saw} after {search:,} control steps, {anew} after {final:,}: {luck}, and {other}."]


def _about_fitness(run: Run) -> list[str]:
    champion, reference = run.champion, run.reference
    if not champion or not reference or not champion.fitness or not reference.fitness:
        return []
    said = []
    if champion.fitness.mean < reference.fitness.mean:
        said.append(
            "The champion uses less material, but it does not do better at the task: its fitness "
            f"is {number(champion.fitness.mean)} against "
            f"{in_unit(reference.fitness.mean, 'fitness', run.fitness_unit)} of the reference "
            "design; its efficiency comes from the small volume."
        )
    trained = reference.fitness.values
    nowhere = sum(value <= 0 for value in trained)
    if reference.fitness.mean <= 0:
        said.append(
            "The reference design did not get anywhere at this budget, so no ratio is given; "
            "train longer for a fair comparison."
        )
    elif nowhere:
        said.append(
            f"{nowhere} of {len(trained)} trainings of the reference design did not get anywhere "
            "at all (a fitness of 0 or less): what is divided by their mean can be any number, so "
            "no ratio is a headline; train longer for a fair comparison."
        )
    return said


def _about_height(run: Run) -> list[str]:
    """Say so if most of the height that a robot reached is the one at which it stands anyway."""
    champion = run.champion
    if run.task.goal.name != "height" or champion is None or champion.fitness is None:
        return []
    highest, gained = champion.fitness.mean, champion.behaviour.get("height_gain_m")
    if gained is None or gained >= highest / 2:
        return []
    return [
        f"Of the {number(highest)} m that the champion reaches, {number(highest - gained)} m is "
        f"the height at which its torso starts: it gains {number(gained)} m. A taller robot "
        "is worth more in this task without a motion."
    ]


def _about_limits(run: Run) -> list[str]:
    settings, reference = run.manifest.settings, run.reference
    if reference is None:
        return []
    beyond = []
    if settings.max_volume is not None and reference.volume > settings.max_volume:
        beyond.append(f"volume ({number(reference.volume)} m³)")
    density = reference.body.get("density", 0.0)
    if settings.max_density is not None and density > settings.max_density:
        beyond.append(f"density ({number(density)} kg/m³)")
    if not beyond:
        return []
    seat = (
        "it is champion all the same, since no other design of the final could be"
        if run.champion_role == "reference"
        else "it is shown to compare with, and could not be champion"
    )
    return [f"The reference design is beyond this run's limit of {' and '.join(beyond)}: {seat}."]


def _about_audits(run: Run) -> list[str]:
    return [f"Not champion, since it failed its audit: {one}" for one in run.passed_over]


def _about_slimness(run: Run, champion: TrainedDesign) -> list[str]:
    """Say so if the morphology is the reference's with other radii, which nobody had to invent."""
    scale = slim_scale(run.task, champion.design.morphology.parameters)
    if scale is None:
        return []
    return [
        f"Its morphology is the reference's with all radii scaled by {scale:.3g}, as "
        "--method slim-reference would try it: the search found no better one."
    ]


def _about_matter(champion: TrainedDesign) -> list[str]:
    density = champion.body.get("density", 0.0)
    if density <= STEEL:
        return []
    return [
        f"Its mass divided by its volume is {number(density, 3)} kg/m³ (steel has "
        f"{number(STEEL)}): the task fixes the mass, so a robot this thin would have to be made of "
        "impossibly dense matter."
    ]


def _about_bounds(run: Run, champion: TrainedDesign) -> list[str]:
    # What a language model proposes is held to the bounds alone.
    sampled = run.manifest.designer in ("", "offline")
    task = run.task.searched() if sampled else run.task
    parameters = champion.design.morphology.parameters
    at_bound = at_bounds(task, parameters)
    if not at_bound:
        return []
    stand = "stands at a bound" if len(at_bound) == 1 else "stand at the bounds"
    said = (
        f"{', '.join(at_bound)} {stand} of the {'search' if sampled else 'task'}: the bounds "
        "decided part of this design."
    )
    at_tasks = at_bounds(run.task, parameters)
    if wider := [name for name in at_bound if name not in at_tasks]:
        of = "" if len(wider) == len(at_bound) else f" of {', '.join(wider)}"
        said += f" The task itself allows more{of} than this search tried."
    return [said]
