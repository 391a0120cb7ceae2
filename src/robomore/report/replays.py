"""Which designs of a run are shown in motion, and their episodes."""

from __future__ import annotations

import logging
from collections.abc import Iterator

from robomore.errors import InputError, InvalidMorphology, UnstableSimulation
from robomore.runs import Run, TrainedDesign
from robomore.runs.lineage import Record
from robomore.store import RunFolder

_log = logging.getLogger(__name__)

MOST = 12
"""Episodes in one file; each takes some 60 kB and half a second."""


def chosen(run: Run, most: int = MOST) -> dict[str, str]:
    """Return the evaluations to be shown in motion, and what they are called.

    Champion and reference come first, then the other pairs of the final, the champion's lineage,
    and the best of the search, as far as their policies were kept.

    Args:
        run: finished or not.
        most: how many.
    """
    found: dict[str, str] = {}
    for name, one in _groups(run):
        if one and one.trained:
            found.setdefault(one.best(run.objective).key, name)
    ranked = sorted(run.searched, key=lambda record: -_score(record, run.objective))
    for record in (*reversed(run.lineage), *ranked):
        if record.evaluation.ok:
            found.setdefault(record.evaluation.key, run.plan.describe(record.place))
    kept = set(kept_policies(run))
    return dict([(key, name) for key, name in found.items() if key in kept][:most])


def kept_policies(run: Run) -> Iterator[str]:
    """Yield the keys of the evaluations whose policies lie in the run's folder."""
    folder = RunFolder(run.folder)
    names = set(folder.files.names(folder.artifacts.name))
    yield from (e.key for e in run.evaluations if e.ok and e.artifact in names)


def recorded(run: Run, key: str, name: str) -> bytes | None:
    """Return one packed episode of an evaluation; `None`, with a warning, where there can be none.

    That is where its file is damaged, or where the task was edited since.
    """
    # Only here is anything simulated: reading a run must not load the simulator.
    import numpy as np

    from robomore.rendering.replay import packed_replay

    evaluation = run.evaluation(key)
    parameters = evaluation.design.morphology.parameters
    try:
        policy = run.load_policy(key)
        # A policy from elsewhere may act by numbers that overflow; its robot then just stands.
        with np.errstate(all="ignore"):
            return packed_replay(run.task, parameters, policy.act, name)
    except (InputError, InvalidMorphology, UnstableSimulation, ValueError) as error:
        _log.warning("%s cannot be shown in motion: %s", key, error)
        return None


def _groups(run: Run) -> tuple[tuple[str, TrainedDesign | None], ...]:
    champion = run.champion.name if run.champion else "champion"
    return (
        (champion, run.champion),
        ("reference design", run.reference),
        ("found design", run.found),
        ("found morphology, reference reward", run.morphology_only),
        ("reference morphology, found reward", run.reward_only),
    )


def _score(record: Record, objective: str) -> float:
    score = record.evaluation.score(objective)
    return float("-inf") if score is None else score
