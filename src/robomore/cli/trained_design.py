"""Which body and which policy to play, found in a run or in a design's folder."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from robomore.cli.inputs import read_parameters, read_text
from robomore.errors import InputError
from robomore.store import RunFolder
from robomore.store.champion import check_sums
from robomore.tasks import Task, get_task
from robomore.training.policy import MLPPolicy


@dataclass(frozen=True)
class TrainedDesign:
    """A trained design.

    Attributes:
        task: that it was trained for.
        parameters: of the body, in the task's order.
        policy: that moves it.
        title: for people.
        name: fit for a file.
    """

    task: Task
    parameters: tuple[float, ...]
    policy: MLPPolicy
    title: str
    name: str


def find_trained_design(path: Path) -> TrainedDesign:
    """Return what is to be played.

    Args:
        path: a run folder, a folder with `design.json` and `policy.npz`, or that `design.json`.

    Raises:
        InputError: there is nothing to play.
    """
    if path.name == "design.json":
        path = path.parent
    folder = RunFolder(path)
    if folder.manifest.is_file():
        if (folder.champion / "design.json").is_file():
            return _from_design(folder.champion, path.resolve().name)
        return _best_so_far(folder)
    if not (path / "design.json").is_file():
        raise InputError(
            f"{path} is neither a run folder nor a design (no run.json, no design.json); name a "
            "folder that `robomore run` or `robomore evaluate --out` wrote"
        )
    return _from_design(path, path.resolve().name)


def _from_design(folder: Path, name: str) -> TrainedDesign:
    check_sums(folder)
    file = folder / "design.json"
    text = read_text(file, "name a folder that `robomore run` wrote")
    try:
        task = get_task(json.loads(text)["task"])
    except (ValueError, KeyError, TypeError):
        raise InputError(f"{file} is damaged (it names no task); write it anew") from None
    parameters = read_parameters(task, str(file))
    policy = _load(folder / "policy.npz", task)
    return TrainedDesign(task, parameters, policy, f"{task.title}, {name}", name)


def _best_so_far(folder: RunFolder) -> TrainedDesign:
    from robomore.report.summary import summarise

    summary = summarise(folder.path)
    if summary.champion is None:
        raise InputError(f"{folder.path} has nothing trained yet; wait, or run it on")
    best = summary.champion.evaluations[0]
    policy = _load(folder.artifacts / best.artifact / "policy.npz", summary.task)
    parameters = best.design.morphology.parameters
    name = folder.path.resolve().name
    title = f"{summary.task.title}, best so far of {name}"
    return TrainedDesign(summary.task, parameters, policy, title, name)


def _load(path: Path, task: Task) -> MLPPolicy:
    if not path.is_file():
        raise InputError(
            f"{path} is missing, so nothing moves this design; train it: robomore evaluate "
            f"{task.id} --parameters {path.parent / 'design.json'} "
            f"--reward {path.parent / 'reward.py'} --out DIR"
        )
    try:
        return MLPPolicy.load(path)
    except (ValueError, OSError) as error:
        raise InputError(f"{path} cannot be used ({error}); train the design again") from None
