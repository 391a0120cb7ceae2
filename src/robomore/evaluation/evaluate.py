"""One evaluation: check, compile, train, roll out, and divide fitness by volume.

This process is trusted. The design's reward is trained against in a sandboxed process and never
loaded here, so it cannot reach the numbers.
"""

from __future__ import annotations

import shutil
import time
import traceback
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import msgspec

from robomore.envs.compile import body_facts
from robomore.envs.vector_env import VectorEnv
from robomore.errors import InvalidMorphology, TrainingDiverged, UnstableSimulation
from robomore.evaluation.compiled import compiled_trainer
from robomore.evaluation.measure import choose, measure
from robomore.evaluation.request import Answer, Request, believed
from robomore.evaluation.train import POLICIES
from robomore.rewards.check import check_reward
from robomore.sandbox.call import Containment, run_sandboxed
from robomore.tasks import TASKS, Task
from robomore.tasks.fingerprint import task_key
from robomore.training.compilation import CACHE_VARIABLE
from robomore.training.policy import MLPPolicy
from robomore.training.warm import Shape
from robomore.types import Evaluation, Job, Status


def work(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Do an encoded `Request`; returns an encoded `Answer`. What executors call."""
    request = msgspec.json.decode(payload, type=Request)
    return msgspec.json.encode(evaluate(request, progress))


def evaluate(request: Request, progress: Callable[[int], None]) -> Answer:
    """Return what training the request's design gives. Never raises for a bad design.

    Args:
        request: the job and its folders.
        progress: told the control steps of training done.
    """
    began = time.process_time()
    job, key = request.job, request.key
    scratch = Path(request.scratch)
    policy: MLPPolicy | None = None
    shutil.rmtree(scratch, ignore_errors=True)
    try:
        scratch.mkdir(parents=True)
        evaluation, policy = _evaluate(request, _task(job), scratch, progress)
    except InvalidMorphology as error:
        evaluation = Evaluation(key, job, Status.INVALID_MORPHOLOGY, str(error))
    except UnstableSimulation as error:
        evaluation = Evaluation(key, job, Status.UNSTABLE, str(error))
    except TrainingDiverged as error:
        evaluation = Evaluation(key, job, Status.TRAINING_DIVERGED, str(error))
    except Exception:  # noqa: BLE001  # a fault of ours costs one candidate and keeps its traceback
        evaluation = Evaluation(key, job, Status.FAILED, traceback.format_exc())
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    own_seconds = time.process_time() - began
    evaluation = replace(evaluation, seconds=evaluation.seconds + own_seconds)
    return Answer(evaluation, policy.to_bytes() if policy else b"")


def _task(job: Job) -> Task:
    """Return the job's task, unless this worker knows another one of that name."""
    task = TASKS.get(job.task)
    if task_key(task) != job.task_key:
        raise RuntimeError(
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

    containment = Containment(request.containment)
    robot = VectorEnv(task, parameters, 1)
    shape = Shape(job.trainer, robot.observation_size, robot.action_size)
    compiled = compiled_trainer(shape, containment)
    trained = run_sandboxed(
        "robomore.evaluation.train:train",
        msgspec.json.encode(request),
        scratch,
        job.limits,
        writable=[Path(request.checkpoint)] if request.checkpoint else [],
        on_progress=progress,
        readable=[compiled] if compiled else [],
        environment={CACHE_VARIABLE: str(compiled)} if compiled else {},
        mode=containment,
    )
    if trained.status is not Status.OK:
        failed = Evaluation(
            key, job, trained.status, trained.diagnosis, body=body, seconds=trained.seconds
        )
        return failed, None
    try:
        training = believed(trained.reply)
        policies = [MLPPolicy.load(path) for path in sorted(scratch.glob(POLICIES))[-_MOST:]]
        if not policies:
            raise ValueError("no policy")
    except ValueError as error:
        said = f"training ended without a fault and left nothing that can be used: {error}"
        failed = Evaluation(key, job, Status.CRASHED, said, body=body, seconds=trained.seconds)
        return failed, None
    policy = choose(task, parameters, policies, job.seed)
    measured = measure(task, parameters, policy, job.episodes, job.seed)
    volume = task.volume(parameters)
    evaluation = Evaluation(
        key,
        job,
        Status.OK,
        fitness=measured.fitness,
        volume=volume,
        efficiency=measured.fitness / volume,
        episode_fitness=measured.episode_fitness,
        body=body,
        behaviour=measured.behaviour,
        terms=training.terms,
        steps=job.steps,
        seconds=trained.seconds,
        notes=training.notes,
        curve=training.curve,
    )
    return evaluation, policy


_MOST = 16
"""Policies that are looked at, whatever a child leaves."""
