"""The answer of a run as plain files that need no RoboMoRe to be read."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

import msgspec

from robomore.store.rundir import RunFolder
from robomore.tasks.task import Task
from robomore.types import Evaluation


def save_champion(
    folder: RunFolder, task: Task, retrained: Sequence[Evaluation], objective: str
) -> None:
    """Write `champion/`: design.json, reward.py, robot.xml and the best seed's policy.npz.

    Args:
        folder: of the run.
        task: that the champion is for.
        retrained: the champion's evaluations, one for each training seed.
        objective: decides whose policy is kept.
    """
    best = max(retrained, key=lambda e: (e.ok, e.score(objective) or 0.0))
    partial = folder.champion.with_suffix(".partial")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir()
    write_design(partial, task, retrained)
    if best.artifact:
        policy = folder.artifacts / best.artifact / "policy.npz"
        if policy.is_file():
            shutil.copyfile(policy, partial / "policy.npz")
    shutil.rmtree(folder.champion, ignore_errors=True)
    partial.replace(folder.champion)


def write_design(path: Path, task: Task, evaluations: Sequence[Evaluation]) -> None:
    """Write design.json, reward.py and robot.xml of one design into the folder `path`.

    Args:
        path: an existing folder.
        task: that the design is for.
        evaluations: of the design, one for each training seed.
    """
    design = evaluations[0].design
    facts = {
        "task": task.id,
        "parameters": task.named(design.morphology.parameters),
        "idea": design.morphology.idea,
        "seeds": [evaluation.job.seed for evaluation in evaluations],
        "fitness": [evaluation.fitness for evaluation in evaluations],
        "efficiency": [evaluation.efficiency for evaluation in evaluations],
        "volume": task.volume(design.morphology.parameters),
    }
    (path / "design.json").write_bytes(
        msgspec.json.format(msgspec.json.encode(facts), indent=2) + b"\n"
    )
    (path / "reward.py").write_text(design.reward.source)
    (path / "robot.xml").write_text(task.mjcf(design.morphology.parameters))
