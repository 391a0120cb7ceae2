"""Which policy moves which robot, found in a run or in a design's folder."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from robomore.cli.inputs import read_parameters, read_text
from robomore.envs.vector_env import VectorEnv
from robomore.errors import InputError
from robomore.plain_files import PlainFolder
from robomore.rendering.recording import Recording, record
from robomore.runs import Run, load_run
from robomore.runs.loading import stored_task
from robomore.runs.words import number
from robomore.store import RunFolder, refuse_no_folder
from robomore.store.champion import check_sums
from robomore.tasks import Task
from robomore.training.policy import POLICY, MLPPolicy


@dataclass(frozen=True)
class TrainedPolicy:
    """A policy and the robot that it was trained for.

    Attributes:
        task: that it was trained for.
        parameters: of the morphology, in the task's order.
        policy: that moves it.
        title: for people.
        name: fit for a file.
        folder: of the run or the design that it belongs to.
    """

    task: Task
    parameters: tuple[float, ...]
    policy: MLPPolicy
    title: str
    name: str
    folder: Path

    def recorded(self, seed: int) -> Recording:
        """Return one episode.

        Raises:
            InputError: the policy was trained for another robot.
        """
        robot = VectorEnv(self.task, self.parameters, 1)
        if misfit := self.policy.misfit(robot.observation_size, robot.action_size):
            raise InputError(
                f"the policy of {self.title} {misfit}; play it with its own design.json"
            )
        return record(self.task, self.parameters, self.policy.act, self.title, seed)


def find_policies(
    path: Path, evaluation: str | None = None, reference: bool = False, beside: bool = False
) -> list[TrainedPolicy]:
    """Return what is to be played.

    Args:
        path: a run folder, a folder with `design.json` and `policy.npz`, or that `design.json`.
        evaluation: key of one of the run's evaluations, instead of the champion.
        reference: the reference design of the run's final, instead of the champion.
        beside: the reference design as well.

    Raises:
        InputError: there is nothing to play.
    """
    if path.name == "design.json":
        path = path.parent
    remedy = "a folder that `robomore run` or `robomore evaluate --out` wrote"
    refuse_no_folder(path, remedy)
    if RunFolder(path).manifest.is_file():
        return _from_run(load_run(path), evaluation, reference, beside)
    if evaluation or reference or beside:
        raise InputError(
            f"{path} is no run folder, so it has one design only; leave out --evaluation, "
            "--reference and --beside"
        )
    if not (path / "design.json").is_file():
        raise InputError(
            f"{path} is neither a run folder nor a design (no run.json, no design.json); name "
            f"{remedy}"
        )
    return [_from_design(path)]


def _from_run(
    run: Run, evaluation: str | None, reference: bool, beside: bool
) -> list[TrainedPolicy]:
    if evaluation and reference:
        raise InputError("give --evaluation or --reference, not both")
    if (reference or beside) and run.reference is None:
        raise InputError(f"{run.folder} has no final yet, so no reference design; run it on")
    found = []
    if evaluation:
        found.append(_of_run(run, run.evaluation(evaluation).key, evaluation))
    elif not reference:
        if run.champion is None:
            raise InputError(f"{run.folder} has nothing trained yet; wait, or run it on")
        found.append(_of_run(run, run.champion.best(run.objective).key, run.champion.name))
    if reference or beside:
        assert run.reference is not None
        found.append(_of_run(run, run.reference.best(run.objective).key, run.reference.name))
    return found


def _of_run(run: Run, key: str, name: str) -> TrainedPolicy:
    parameters = run.evaluation(key).design.morphology.parameters
    title = f"{run.task.title}, {name}"
    file = f"{run.folder.resolve().name}-{name.replace(' ', '-')}"
    return TrainedPolicy(run.task, parameters, run.load_policy(key), title, file, run.folder)


def _from_design(folder: Path) -> TrainedPolicy:
    PlainFolder(folder).check()
    check_sums(folder)
    file = folder / "design.json"
    text = read_text(file, "name a folder that `robomore run` wrote")
    try:
        task = stored_task(PlainFolder(folder), json.loads(text)["task"])
    except (ValueError, KeyError, TypeError, RecursionError):
        raise InputError(f"{file} is damaged (it names no task); write it anew") from None
    parameters = read_parameters(task, str(file))
    path, name = folder / POLICY, folder.resolve().name
    if not path.is_file():
        raise InputError(
            f"{path} is missing, so nothing moves this design; train it: robomore evaluate "
            f"{task.id} --parameters {file} --reward {folder / 'reward.py'} --out DIR"
        )
    try:
        policy = MLPPolicy.load(path)
    except (ValueError, OSError) as error:
        raise InputError(f"{path} cannot be used ({error}); train the design again") from None
    return TrainedPolicy(task, parameters, policy, f"{task.title}, {name}", name, folder)


def described(recording: Recording) -> str:
    """Return what happened in an episode, in words."""
    said = f"{number(recording.distance, 3)} m forward in {number(recording.seconds, 3)} s"
    if recording.task.goal.motion == "upward":
        said = f"{number(recording.height, 3)} m high, {said}"
    return f"{recording.title}: {said}{', then it fell' if recording.fell else ''}"
