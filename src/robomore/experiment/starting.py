"""What a run starts from: checked before anything begins, and put where its method looks for it."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from robomore.errors import InputError, InvalidMorphology
from robomore.rewards.check import Finding, check_reward
from robomore.rewards.dry_run import DryRun
from robomore.runs import Run
from robomore.sandbox.call import Containment
from robomore.search.named_starts import NAMED_STARTS, named_start
from robomore.tasks import Task
from robomore.types import Design, Morphology, Reward, Start

log = logging.getLogger(__name__)

Given = Start | Design | Morphology | Reward | Run | str
"""What a search can start from: one's own values, the champion of an earlier run, or a name of
`NAMED_STARTS`."""


def checked_starts(task: Task, given: Sequence[Given]) -> tuple[Start, ...]:
    """Return what was given as starts that can be trained in `task`.

    Args:
        task: of the new run, with its limits as rules.
        given: in the order in which they are tried.

    Raises:
        InputError: a run has no design yet or is of another robot, or a reward has an error.
        InvalidMorphology: the task refuses a morphology.
    """
    starts = []
    for number, one in enumerate(given, start=1):
        start = _as_start(task, one, f"start {number}")
        if start.morphology:
            try:
                parameters = task.check(start.morphology.parameters)
            except InvalidMorphology as error:
                raise InvalidMorphology(f"{start.origin}: {error}") from None
            idea = f"given ({start.origin}): {start.morphology.idea}".removesuffix(": ")
            start = replace(start, morphology=Morphology(parameters, idea))
        if start.reward:
            _refuse_errors(start.origin, check_reward(start.reward.source))
            idea = f"given ({start.origin}): {start.reward.idea}".removesuffix(": ")
            start = replace(start, reward=Reward(start.reward.source, idea))
        starts.append(start)
    return tuple(starts)


def try_rewards(task: Task, given: Sequence[tuple[str, str]], containment: Containment) -> None:
    """Try rewards out on moving robots before anything is trained under them.

    It is the dry run that a language model's reward gets, and `robomore check-reward` makes.
    Warnings are logged. The task's own reward is not tried.

    Args:
        task: whose robots move.
        given: where each reward comes from, and its text.
        containment: how they are kept in.

    Raises:
        InputError: a reward has an error; the message names each with its line.
    """
    for origin, source in given:
        if source == task.reward:
            continue
        _refuse_errors(origin, check_reward(source))
        with TemporaryDirectory(prefix="robomore-") as scratch:
            found = DryRun(task, Path(scratch), containment)(source)
        _refuse_errors(origin, found)
        for finding in found:
            if finding.severity == "warning":
                log.warning("%s, line %d: %s", origin, finding.line, finding.message)


def _refuse_errors(origin: str, findings: Sequence[Finding]) -> None:
    faults = [finding for finding in findings if finding.severity == "error"]
    if faults:
        said = "; ".join(f"line {fault.line}: {fault.message.rstrip('.')}" for fault in faults)
        raise InputError(
            f"{origin}: the reward cannot be used: {said}; correct it (`robomore check-reward` "
            "checks it in a second)"
        )


def _as_start(task: Task, given: Given, name: str) -> Start:
    match given:
        case Start():
            return given
        case Design():
            return Start(name, given.morphology, given.reward)
        case Morphology():
            return Start(name, given)
        case Reward():
            return Start(name, reward=given)
        case Run():
            return champion_of(task, given)
        case str() if given in NAMED_STARTS:
            return named_start(task, given)
    what = repr(given) if isinstance(given, str) else f"a {type(given).__name__}"
    raise InputError(
        f"a search cannot start from {what}; give a Design, a Morphology, a Reward, a Run, or one "
        f"of the names {', '.join(NAMED_STARTS)}"
    )


def champion_of(task: Task, run: Run) -> Start:
    """Return the champion of a run of the same robot as a start.

    Raises:
        InputError: it has none yet, or its robot has other parameters.
    """
    origin = str(run.folder)
    if run.champion is None:
        raise InputError(f"{origin} has no design yet; run it on, or name another run")
    if run.task.names != task.names:
        raise InputError(
            f"{origin} is a run of {run.task.id}, whose parameters are not those of {task.id}"
        )
    design = run.champion.design
    return Start(origin, design.morphology, design.reward)
