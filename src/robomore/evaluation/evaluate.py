"""One evaluation: check, compile, train, roll out, and divide fitness by volume.

This process is trusted. The design's reward is trained against in a sandboxed process and never
loaded here, so it cannot reach the numbers.
"""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from robomore.envs.compile import body_facts
from robomore.envs.try_out import try_out
from robomore.envs.vector_env import VectorEnv
from robomore.errors import (
    FitnessFailed,
    InvalidMorphology,
    TrainingDiverged,
    UnfitWorker,
    UnstableSimulation,
)
from robomore.evaluation.compiled import compiled_trainer
from robomore.evaluation.measure import choose, measure
from robomore.evaluation.request import Answer, Request, checked_training
from robomore.evaluation.train import POLICIES
from robomore.plain_files import PlainFolder
from robomore.rewards.check import check_reward
from robomore.sandbox.call import Containment, run_sandboxed
from robomore.tasks import Task
from robomore.tasks.fingerprint import task_key
from robomore.tasks.registry import carried_task
from robomore.text import one_line, to_json
from robomore.training.checkpoint import drop_older
from robomore.training.compilation import CACHE_VARIABLE
from robomore.training.policy import MLPPolicy
from robomore.training.settings import MOST_EVAL_CHECKPOINTS, hidden_layers
from robomore.training.warm import Shape
from robomore.types import Evaluation, Job, Status


def evaluate(request: Request, progress: Callable[[int], None]) -> Answer:
    """Return what training the request's design gives. Never raises for a bad design.

    Args:
        request: the job and its folders.
        progress: told the control steps of training done.

    Raises:
        UnfitWorker: the task is another one on this machine.
    """
    began = time.process_time()
    job, key = request.job, request.key
    scratch = Path(request.scratch)
    policy: MLPPolicy | None = None
    scratch.parent.mkdir(parents=True, exist_ok=True)
    above = PlainFolder(scratch.parent, follow=False)
    try:
        above.remove(scratch.name)
        above.make(scratch.name)
        evaluation, policy = _evaluate(request, _task(request), scratch, progress)
    except UnfitWorker:
        raise
    except Exception as error:  # noqa: BLE001  # a fault of ours costs one candidate
        evaluation = Evaluation(key, job, *_end(error))
    finally:
        with suppress(OSError):  # the next training here tries again, and fails if it must
            above.remove(scratch.name)
    own_seconds = time.process_time() - began
    evaluation = replace(evaluation, seconds=evaluation.seconds + own_seconds)
    return Answer(evaluation, policy.to_bytes() if policy else b"")


def _end(error: Exception) -> tuple[Status, str]:
    """Return how an evaluation ends that raised, and why; a fault of ours keeps its traceback."""
    for kind, status in _ENDS.items():
        if isinstance(error, kind):
            return status, str(error)
    return Status.FAILED, "".join(traceback.format_exception(error))


_ENDS: dict[type[Exception], Status] = {
    InvalidMorphology: Status.INVALID_MORPHOLOGY,
    UnstableSimulation: Status.UNSTABLE,
    FitnessFailed: Status.FAILED,
    TrainingDiverged: Status.TRAINING_DIVERGED,
}


def _task(request: Request) -> Task:
    """Return the job's task, unless this worker knows another one of that name."""
    job = request.job
    task = carried_task(job.task, request.task)
    if task_key(task) != job.task_key:
        raise UnfitWorker(
            f"this worker knows the task {job.task} with another content than the run does: "
            "its package was edited, or is of another version here; start the run anew"
        )
    return task


def _evaluate(
    request: Request, task: Task, scratch: Path, progress: Callable[[int], None]
) -> tuple[Evaluation, MLPPolicy | None]:
    """Return the evaluation and, if all went well, the policy."""
    job, key = request.job, request.key
    parameters = task.check(job.design.morphology.parameters)
    body = body_facts(task, parameters)
    faults = [f for f in check_reward(job.design.reward.source) if f.severity == "error"]
    if faults:
        said = "; ".join(f"line {fault.line}: {fault.message}" for fault in faults)
        return Evaluation(key, job, Status.INVALID_REWARD, said, body=body), None

    try_out(task, parameters)
    containment = Containment(request.containment)
    robot = VectorEnv(task, parameters, 1)
    shape = Shape(job.trainer, robot.observation_size, robot.action_size)
    compiled = compiled_trainer(shape, containment)
    trained = run_sandboxed(
        "robomore.evaluation.train:train",
        to_json(request),
        scratch,
        job.limits,
        writable=[Path(request.checkpoint)] if request.checkpoint else [],
        on_progress=progress,
        readable=[compiled] if compiled else [],
        environment={CACHE_VARIABLE: str(compiled)} if compiled else {},
        mode=containment,
    )
    if request.checkpoint and trained.status is Status.OK:
        # It may not remove anything itself: what it can remove, it could hide. One that was ended
        # may have died over its latest checkpoint, so that the older one is all there is.
        drop_older(Path(request.checkpoint))
    known = Evaluation(
        key, job, trained.status, trained.diagnosis, body=body, seconds=trained.seconds
    )
    if not known.ok:
        return known, None
    try:
        training = checked_training(trained.reply)
        # What fails from here on has cost its training, and says how it went.
        known = replace(
            known,
            terms=training.terms,
            steps=max(0, min(training.steps, job.steps)),
            notes=training.notes,
            curve=training.curve,
        )
        policy = choose(task, parameters, _policies(job, robot, scratch), job.seed)
    except ValueError as error:
        # The names of files that it left may stand in the reason.
        why = one_line(str(error))
        said = f"training ended without a fault and left nothing that can be used: {why}"
        return replace(known, status=Status.CRASHED, diagnosis=said), None
    except Exception as error:  # noqa: BLE001  # see `_end`
        return _failed(known, error), None
    try:
        measured = measure(task, parameters, policy, job.episodes, job.seed)
    except Exception as error:  # noqa: BLE001  # see `_end`
        return _failed(known, error), None
    volume = task.volume(parameters)
    evaluation = replace(
        known,
        fitness=measured.fitness,
        volume=volume,
        efficiency=measured.fitness / volume,
        episode_fitness=measured.episode_fitness,
        behaviour=measured.behaviour,
    )
    return evaluation, policy


def _failed(known: Evaluation, error: Exception) -> Evaluation:
    status, diagnosis = _end(error)
    return replace(known, status=status, diagnosis=diagnosis)


def _policies(job: Job, robot: VectorEnv, scratch: Path) -> Iterator[MLPPolicy]:
    """Yield what the sandboxed process left, one at a time, the latest last.

    Raises:
        ValueError: one of them is no policy such as this trainer leaves.
    """
    hidden = hidden_layers(job.trainer)
    for path in sorted(scratch.glob(POLICIES))[-MOST_EVAL_CHECKPOINTS:]:
        policy = MLPPolicy.load(path)
        if misfit := policy.misfit(robot.observation_size, robot.action_size):
            raise ValueError(f"{path.name} {misfit}")
        if hidden is not None and policy.sizes[1:-1] != hidden:
            raise ValueError(f"{path.name} has other layers than this trainer's")
        yield policy
