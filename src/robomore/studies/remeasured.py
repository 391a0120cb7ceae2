"""What the best so far of a search is worth when it is measured again.

A search sees one number of each design, and its best so far is the best of many noisy numbers. The
policy behind each of these numbers is kept, so it can be measured again in other episodes, which
costs no training and has no luck of the choice in it.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
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
from robomore.types import Evaluation

FILE = "remeasured.json"
"""In a study's folder: the score of each evaluation that was once the best so far, by its key."""

LEAST_EPISODES = 10
_MOST_BYTES = 2**24

log = logging.getLogger(__name__)


def incumbents(run: Run) -> list[Point]:
    """Return the points of a search at which another design became the best, or had a new seed."""
    found: list[Point] = []
    for point in progress(run):
        if not found or _keys(point) != _keys(found[-1]):
            found.append(point)
    return found


class Remeasured:
    """Scores of evaluations that were the best so far, measured again and kept in a study's folder.

    Several threads may add runs at once.

    Attributes:
        scores: by the evaluation's key.
    """

    def __init__(self, out: Path) -> None:
        """Read what is known.

        Args:
            out: the study's folder, which may be missing.

        Raises:
            InputError: what is kept there cannot be read.
        """
        self._files = PlainFolder(out)
        self._lock = threading.Lock()
        self.scores = _read(self._files)

    def add(self, run: Run, begin: Callable[[int], None] = lambda count: None) -> None:
        """Measure what was the best so far in a run's search, unless it is known.

        An evaluation without a policy is left out: nothing of it can be measured.

        Args:
            run: a finished run.
            begin: is told how many policies are measured, if there is one.

        Raises:
            InputError: the scores cannot be written.
        """
        best = {e.key: e for point in incumbents(run) for e in point.leader}
        new = [e for e in best.values() if e.key not in self.scores and e.artifact]
        if run.task_changes:
            new = []
        if new:
            begin(len(new))
        for evaluation in new:
            score = _again(run, evaluation)
            if score is not None:
                with self._lock:
                    self.scores[evaluation.key] = score
                    _write(self._files, self.scores)
        if lost := [key for key in best if key not in self.scores]:
            log.warning(
                "%s is left out of the curves: %s cannot be measured again",
                run.folder.name,
                ", ".join(lost),
            )


def _keys(point: Point) -> list[str]:
    return [evaluation.key for evaluation in point.leader]


def _again(run: Run, evaluation: Evaluation) -> float | None:
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
