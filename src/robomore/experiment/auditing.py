"""Audits of what a run keeps: one that is asked for, and those before the champion's seat."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

from robomore.audit import Audit, Subject, audit
from robomore.audit.seeds import REPORTED
from robomore.envs.vector_env import VectorEnv
from robomore.errors import FitnessFailed, InputError
from robomore.evaluation.evaluator import Evaluator
from robomore.plain_files import PlainFolder
from robomore.runs import load_run
from robomore.store import RunFolder
from robomore.store.audit import AUDIT, load_audit, save_audit
from robomore.store.champion import best_seed
from robomore.tasks import Task
from robomore.tasks.portable import is_foreign
from robomore.training.policy import POLICY, MLPPolicy
from robomore.types import Evaluation


def audit_run(folder: str | Path, key: str | None = None) -> Audit:
    """Audit the policy of one evaluation of a run, and write the audit beside it.

    Args:
        folder: of the run; it may still go on.
        key: of the evaluation, or its beginning; the champion's best training seed by default.

    Raises:
        InputError: there is no such run, evaluation or policy, the policy is of another robot, or
            the folder cannot be written.
    """
    run = load_run(folder)
    if run.task_changes:
        raise InputError(
            f"the task {run.task.id} was edited after the run {run.folder} "
            f"({', '.join(run.task_changes)}), so its policy cannot be audited; install the "
            "version that it was made with"
        )
    _refuse_foreign(run.task)
    policy = run.load_policy(key)
    evaluation = run.kept(key)
    parameters = evaluation.design.morphology.parameters
    _refuse_another_robot(run.task, parameters, policy)
    subject = Subject(run.task, parameters, policy, evaluation.fitness)
    return _written(RunFolder(run.folder), evaluation.artifact, audit(subject))


def audit_design(folder: Path, task: Task, parameters: Sequence[float], policy: MLPPolicy) -> Audit:
    """Audit a design of a folder with `design.json` and `policy.npz`, and write the audit there.

    It is compared with the fitness that `design.json` tells: of its training seeds that of the
    best, which a policy is kept of, unless an earlier audit of this policy names another of them.

    Raises:
        InputError: the fitness is a function of the folder, the policy is of another robot, or the
            folder cannot be written.
    """
    _refuse_foreign(task)
    _refuse_another_robot(task, task.check(parameters), policy)
    files = PlainFolder(folder)
    told = _told_by_design(files, policy)
    found = audit(Subject(task, task.check(parameters), policy, told))
    _write(files, AUDIT, found)
    return found


def _refuse_foreign(task: Task) -> None:
    if is_foreign(task.goal):
        raise InputError(
            f"the fitness of {task.id} is a function of its task file, which is not executed from "
            "a folder, so nothing can be measured anew"
        )


def _refuse_another_robot(task: Task, parameters: Sequence[float], policy: MLPPolicy) -> None:
    robot = VectorEnv(task, parameters, 1)
    if misfit := policy.misfit(robot.observation_size, robot.action_size):
        raise InputError(
            f"the policy {misfit}; name the folder of the {task.id} that it was trained with"
        )


def _earlier(files: PlainFolder, name: str, policy: MLPPolicy) -> Audit | None:
    """Return an audit of this policy; one that is damaged, or of another policy, is made anew."""
    try:
        earlier = load_audit(files, name)
    except ValueError:
        return None
    return earlier if earlier and earlier.policy == policy.digest else None


def _told_by_design(files: PlainFolder, policy: MLPPolicy) -> float | None:
    try:
        told = json.loads(files.read("design.json"))["fitness"]
        fitness = [float(one) for one in told if one is not None and math.isfinite(one)]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None  # a design that a user wrote tells none
    earlier = _earlier(files, AUDIT, policy)
    for verdict in earlier.verdicts if earlier else ():
        if verdict.numbers.get(REPORTED) in fitness:
            return verdict.numbers[REPORTED]
    return max(fitness, default=None)


def no_doubt(group: Sequence[Evaluation]) -> str:
    """Say nothing against anybody."""
    return ""


def doubt(evaluator: Evaluator, task: Task, objective: str, group: Sequence[Evaluation]) -> str:
    """Return why a group of the final fails its audit; nothing if it passes.

    The policy of its best training seed is audited: that is the one which a champion keeps.
    """
    best = best_seed(group, objective)
    evaluator.restore_policies([best])
    files, name = evaluator.folder.files, f"{evaluator.folder.artifacts.name}/{best.artifact}"
    if not best.artifact:
        return "it has no policy that can be audited"
    policy = MLPPolicy.load(evaluator.folder.path / name / POLICY)
    known = _earlier(files, f"{name}/{AUDIT}", policy)
    if known is None:
        parameters = best.design.morphology.parameters
        try:
            _refuse_another_robot(task, parameters, policy)
            found = audit(Subject(task, parameters, policy, best.fitness))
        except (FitnessFailed, InputError) as error:
            return f"its fitness cannot be measured in other episodes: {error}"
        known = _written(evaluator.folder, best.artifact, found)
    return " ".join(f"{one.check}: {one.says}" for one in known.failed)


def _written(folder: RunFolder, artifact: str, found: Audit) -> Audit:
    _write(folder.files, f"{folder.artifacts.name}/{artifact}/{AUDIT}", found)
    return found


def _write(files: PlainFolder, name: str, found: Audit) -> None:
    try:
        save_audit(files, name, found)
    except OSError as error:
        raise InputError(
            f"cannot write {files.path / name} ({error.strerror}); copy the folder to where you "
            "may write, and audit the copy"
        ) from None
