"""What the best so far of a search is worth when it is measured again.

A search sees one number of each design, and its best so far is the best of many noisy numbers. The
policy behind each of these numbers is kept, so it can be measured again in other episodes, which
costs no training and has no luck of the choice in it.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import msgspec

from robomore.errors import InputError, RoboMoReError
from robomore.evaluation.measure import measure
from robomore.identity import derive_seed
from robomore.plain_files import PlainFolder
from robomore.runs import Run
from robomore.runs.progress import Point, progress
from robomore.text import to_json

FILE = "remeasured.json"
"""In a study's folder: the score of each evaluation that was once the best so far, by its key."""

LEAST_EPISODES = 10
_MOST_BYTES = 2**24

log = logging.getLogger(__name__)


def incumbents(run: Run) -> list[Point]:
    """Return the points of a search that were better than all before them, in order."""
    found: list[Point] = []
    for point in progress(run):
        if not found or point.best > found[-1].best:
            found.append(point)
    return found


def remeasure(runs: Iterable[Run], out: Path) -> dict[str, float]:
    """Return the scores of all incumbents by key, measured again; those known are read from `out`.

    An evaluation without a policy is left out: nothing of it can be measured.

    Args:
        runs: of a study.
        out: the study's folder.

    Raises:
        InputError: the file in `out` cannot be read or written.
    """
    files = PlainFolder(out)
    known = _read(files)
    for run in runs:
        for point in incumbents(run) if not run.task_changes else []:
            evaluation = point.record.evaluation
            if evaluation.key in known or not evaluation.artifact:
                continue
            score = _again(run, point)
            if score is not None:
                known[evaluation.key] = score
                _write(files, known)
    return known


def _again(run: Run, point: Point) -> float | None:
    evaluation = point.record.evaluation
    job = evaluation.job
    try:
        found = measure(
            run.task,
            job.design.morphology.parameters,
            run.load_policy(evaluation.key),
            max(LEAST_EPISODES, job.episodes),
            derive_seed(job.seed, "measured again"),
        )
    except (RoboMoReError, ValueError) as error:  # such as a policy that fits another robot
        log.warning("%s of %s cannot be measured again: %s", evaluation.key, run.folder, error)
        return None
    volume = run.task.volume(job.design.morphology.parameters)
    again = replace(
        evaluation,
        fitness=found.fitness,
        efficiency=found.fitness / volume,
        behaviour=found.behaviour,
    )
    return again.score(run.objective)


def _read(files: PlainFolder) -> dict[str, float]:
    if not files.is_file(FILE):
        return {}
    try:
        return msgspec.json.decode(files.read(FILE, _MOST_BYTES), type=dict[str, float])
    except (msgspec.DecodeError, OSError) as error:
        raise InputError(
            f"{files.path / FILE} cannot be read ({error}); remove it, and it is made again"
        ) from None


def _write(files: PlainFolder, known: dict[str, float]) -> None:
    try:
        files.write(FILE, msgspec.json.format(to_json(known), indent=1) + b"\n")
    except OSError as error:
        raise InputError(
            f"cannot write to {files.path} ({error.strerror}); name another --out"
        ) from None
