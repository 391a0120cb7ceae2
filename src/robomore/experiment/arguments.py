"""What callers from Python hand over, refused before anything starts if it is of a wrong kind."""

from __future__ import annotations

import logging
import os
from dataclasses import replace
from numbers import Integral
from typing import get_args

from robomore.errors import InputError
from robomore.search import SearchContext, SearchMethod
from robomore.settings import Budget, Objective, RunSettings
from robomore.tasks import Task

log = logging.getLogger(__name__)

_FAR = 1.25
"""Factor between a budget and the size of a search from which on they differ much."""


def ensure_usable(
    seed: object, workers: object, budget_steps: object, time_limit: object, out: object
) -> None:
    """Refuse arguments of `robomore.run` that are of a wrong kind or out of range.

    Raises:
        InputError: naming the value, the range and the remedy.
    """
    ensure_whole("the seed", seed, 0)
    if workers is not None:
        ensure_whole("the number of workers", workers, 1)
    if budget_steps is not None:
        ensure_whole("the budget in control steps", budget_steps, 1)
    if time_limit is not None and not (isinstance(time_limit, int | float) and time_limit > 0):
        raise InputError(
            f"the time limit is {time_limit!r}; give a positive number, in s (on the command line "
            "also 90s, 30m or 2h)"
        )
    if out is not None and not isinstance(out, str | os.PathLike):
        raise InputError(f"the run's folder is {out!r}; give its path as a text or a Path")


def ensure_whole(what: str, value: object, least: int) -> None:
    """Refuse what is no whole number from `least` up.

    Raises:
        InputError: naming `what` and its value.
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise InputError(f"{what} is {value!r}; give a whole number from {least} up")


def ensure_settings(settings: RunSettings) -> None:
    """Refuse settings from Python that would only show to be none after the search.

    Raises:
        InputError: naming the value, the range and the remedy.
    """
    if settings.objective not in (known := get_args(Objective)):
        raise InputError(f"the objective is {settings.objective!r}; choose {', '.join(known)}")
    for stage in ("candidate", "final"):
        budget: Budget = getattr(settings, stage)
        ensure_whole(f"{stage}.steps", budget.steps, 1)
        ensure_whole(f"{stage}.episodes", budget.episodes, 1)
    ensure_whole("final.finalists", settings.final.finalists, 1)
    ensure_whole("final.seeds", settings.final.seeds, 1)
    ensure_whole("evaluations", settings.evaluations, 1)


def refuse_useless(
    task: Task,
    settings: RunSettings,
    method: SearchMethod,
    designer: object,
    budget_steps: int | None,
) -> None:
    """Refuse limits and designers that make no sense, before anything is started.

    Raises:
        InputError: naming the value, the range and the remedy.
    """
    goal = task.goal
    if settings.objective == "transport-economy" and goal.motion != "forward":
        raise InputError(
            f"{task.id} is about {goal.name} and transports nothing; choose --objective fitness or "
            "efficiency"
        )
    if settings.objective == "efficiency" and goal.may_be_negative:
        raise InputError(
            f"the fitness of {task.id} ({goal.name}) may be below 0, and divided by the volume it "
            "would then reward material; choose --objective fitness"
        )
    if designer is not None and not method.needs_designer:
        raise InputError(
            f"the method {settings.method.name!r} asks no designer; leave the designer out"
        )
    if budget_steps is not None and budget_steps < settings.candidate.steps:
        raise InputError(
            f"a budget of {budget_steps} steps does not pay for one candidate of "
            f"{settings.candidate.steps}; give a larger --budget-steps, or smaller --steps"
        )


def warn_of_size(method: SearchMethod, context: SearchContext, budget_steps: int | None) -> None:
    """Log a warning where a method that is sized by `evaluations` plans for another budget.

    Such a method splits its trainings into stages or generations. One that the budget ends early is
    not the method that its name says, and one that stops early leaves the rest unspent.
    """
    if budget_steps is None:
        return
    paid = max(1, budget_steps // context.candidate.steps)
    own, fitting = (
        sum(stage.steps for stage in method.plan(one).stages)
        for one in (context, replace(context, evaluations=paid))
    )
    # The sizes of `robomore`, and evaluations among a method's own options, do not follow.
    if own != fitting and not budget_steps / _FAR <= own <= budget_steps * _FAR:
        log.warning(
            "the budget of %d steps pays for %d full trainings, and the search is sized for %d: "
            "give --evaluations %d beside --budget-steps",
            budget_steps,
            paid,
            round(own / context.candidate.steps),
            paid,
        )
