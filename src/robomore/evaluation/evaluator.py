"""Batches of evaluations: look up what is known, have the rest done, write each down at once."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import Any

from robomore.errors import NoWorker, RunFolderError, TimeLimitReached
from robomore.evaluation.encoded import Encoded
from robomore.evaluation.request import Request, checked_answer
from robomore.events import BatchBegan, Finished, Observer, Progressed, Started, ignore
from robomore.executors.executor import (
    Carry,
    Done,
    Executor,
    Failed,
    Outcome,
    Progress,
    RemoteExecutor,
    never,
)
from robomore.identity import content_key, derive_seed, job_key, training_key
from robomore.settings import Budget
from robomore.store.ledger import Ledger
from robomore.store.rundir import RunFolder
from robomore.tasks.fingerprint import task_key
from robomore.tasks.portable import task_content
from robomore.tasks.task import Task
from robomore.text import one_line
from robomore.training.policy import POLICY, MLPPolicy
from robomore.training.tuned import resolve
from robomore.types import (
    Design,
    Evaluation,
    Job,
    Limits,
    Morphology,
    Place,
    Status,
    TrainerSettings,
    Trial,
)

_WORK = "robomore.evaluation.work:work"
_GRACE_SECONDS = 300.0
"""What a worker may need beside training: compiling, measuring, writing."""
_TRIES = 2
"""A process that dies may have been killed from outside; one that dies twice has a reason."""
_SUSPECT = (Status.CRASHED, Status.FAILED)
"""Ends that may be the machine's fault and not the design's."""

_LONGEST = 500
"""Characters of why an answer cannot be read."""

log = logging.getLogger(__name__)


def no_refusal(morphology: Morphology) -> str:
    """Refuse nothing."""
    return ""


@dataclass(slots=True)
class Evaluator:
    """Measures trials for one run.

    Attributes:
        task: what designs are measured in.
        trainer: how policies are trained, but for what is tuned to the robot.
        seed: of the run; with design and repeat it decides each training's seed.
        versions: part of every evaluation's key.
        ledger: what is known, and where new results go.
        folder: of the run.
        executor: does the work.
        containment: `strict` or `relaxed`.
        observe: told what goes on.
        time_is_up: asked before an evaluation is started; once it is, none is.
        refusal: says why a morphology is not for this run although the task accepts it, or nothing.
    """

    task: Task
    trainer: TrainerSettings
    seed: int
    versions: dict[str, str]
    ledger: Ledger
    folder: RunFolder
    executor: Executor
    containment: str = "strict"
    observe: Observer = field(default=ignore)
    time_is_up: Callable[[], bool] = field(default=never)
    refusal: Callable[[Morphology], str] = field(default=no_refusal)
    _left: dict[str, Any] = field(default_factory=dict)
    """Checkpoints that lie on other machines, by name, see `RemoteExecutor`."""
    _failed: set[str] = field(default_factory=set)
    """Keys of evaluations that this process has seen end as a fault of ours."""

    def measure(
        self,
        trials: Sequence[Trial],
        *,
        budget: Budget,
        budget_fraction: float = 1.0,
        refuse: bool = True,
    ) -> list[Evaluation]:
        """Return one evaluation for each trial, in order. Trials of equal content share one.

        Args:
            trials: what is to be measured.
            budget: of each in full.
            budget_fraction: of the steps to train for now. What was trained for a fraction goes on
                from there when it is asked for more in the next batch, and is dropped when it is
                not; either way the numbers are those of training in one go.
            refuse: whether a morphology that is not for this run fails without any training.

        Raises:
            TimeLimitReached: the time is up before all of them are measured; those that are stay
                known.
        """
        jobs = [self._job(trial, budget, budget_fraction) for trial in trials]
        self._drop_checkpoints(but=jobs)
        keys = [job_key(job, self.versions) for job in jobs]
        if refuse:
            self._refuse(dict(zip(keys, jobs, strict=True)))
        kept = {key: one for key in keys if (one := self.ledger.evaluation(key))}
        # A fault of ours, or of the machine, may be gone by now.
        known = {key: one for key, one in kept.items() if self._stands(one)}
        # Trials of equal content are told as one, in the place that comes first.
        asked: dict[str, tuple[Job, Place]] = {}
        for key, job, trial in zip(keys, jobs, trials, strict=True):
            self.ledger.add_place(trial.place, key)
            asked.setdefault(key, (job, trial.place))
        self.observe(BatchBegan(tuple(place for _, place in asked.values()), len(known)))
        for key, found in known.items():
            self.observe(Finished(found, asked[key][1], known=True))
        missing = {key: one for key, one in asked.items() if key not in known}
        for tries_left in reversed(range(_TRIES)):
            known |= self._do(
                missing, accept_crashes=not tries_left, leave_checkpoints=budget_fraction < 1
            )
            missing = {key: job for key, job in missing.items() if key not in known}
            if missing and self.time_is_up():
                raise TimeLimitReached(f"{len(missing)} evaluations of a batch were not started")
        return [known[key] for key in keys]

    def _refuse(self, jobs: Mapping[str, Job]) -> None:
        """Write down a failure for each job whose morphology is not for this run."""
        for key, job in jobs.items():
            why = self.refusal(job.design.morphology)
            if why and self.ledger.evaluation(key) is None:
                refused = Evaluation(key, job, Status.INVALID_MORPHOLOGY, why)
                self.ledger.add_evaluation(refused)

    def restore_policies(self, evaluations: Sequence[Evaluation]) -> None:
        """Train again, to the same numbers, what has lost its policy to damage or to tidying.

        Raises:
            RunFolderError: another policy came of it, so that the file cannot be had again.
        """
        lost = {e.key: e for e in evaluations if e.artifact and not self._has_policy(e)}
        jobs = {key: e.job for key, e in lost.items()}
        with closing(self._trained(jobs, lambda index, steps: None)) as trained:
            for again, policy in trained:
                before = lost[again.key]
                if again.episode_fitness != before.episode_fitness:
                    raise RunFolderError(
                        f"{self.folder.artifacts / before.artifact} has no policy that can be "
                        f"read, and training it again gave a fitness of {again.fitness} in the "
                        f"place of {before.fitness}; restore it from a copy"
                    )
                self._keep_policy(again, policy)

    def _has_policy(self, evaluation: Evaluation) -> bool:
        try:
            MLPPolicy.load(self.folder.artifacts / evaluation.artifact / POLICY)
        except ValueError as error:
            log.warning("%s; it is trained again", error)
            return False
        return True

    def _do(
        self,
        missing: dict[str, tuple[Job, Place]],
        accept_crashes: bool,
        leave_checkpoints: bool,
    ) -> dict[str, Evaluation]:
        """Have `missing` evaluations done and written down; return them by key."""
        keys = list(missing)
        done: dict[str, Evaluation] = {}

        def progress(index: int, steps: int) -> None:
            key = keys[index]
            if steps == 0:
                job, place = missing[key]
                self.observe(Started(key, place, job.steps))
            else:
                self.observe(Progressed(key, steps))

        jobs = {key: job for key, (job, _) in missing.items()}
        with closing(self._trained(jobs, progress, leave_checkpoints)) as trained:
            for evaluation, policy in trained:
                if evaluation.status in _SUSPECT:
                    self.folder.ensure_writable()
                    if not accept_crashes:
                        continue
                evaluation = self._keep_policy(evaluation, policy)
                self.ledger.add_evaluation(evaluation)
                job, place = missing[evaluation.key]
                if not leave_checkpoints:
                    self._discard(self._checkpoint(job))
                    self._left.pop(self._name(job), None)
                done[evaluation.key] = evaluation
                if evaluation.status is Status.FAILED:
                    self._failed.add(evaluation.key)
                self.observe(Finished(evaluation, place, known=False))
        return done

    def _trained(
        self, jobs: Mapping[str, Job], progress: Progress, leave_checkpoints: bool = False
    ) -> Generator[tuple[Evaluation, bytes]]:
        """Yield evaluation and policy of each job as it is done. Nothing is written down."""
        keys = list(jobs)
        wall_seconds = max((job.limits.wall_seconds for job in jobs.values()), default=0.0)
        timeout = wall_seconds + _GRACE_SECONDS
        if isinstance(self.executor, RemoteExecutor):
            carry = {key: self._carry(job, leave_checkpoints) for key, job in jobs.items()}
            payloads = Encoded(jobs, lambda key, job: self._remote_request(key, job, carry[key]))
            outcomes = self.executor.map_remote(
                _WORK, payloads, progress, timeout, self.time_is_up, list(carry.values())
            )
        else:
            payloads = Encoded(jobs, lambda key, job: self._request(key, job, leave_checkpoints))
            outcomes = self.executor.map(_WORK, payloads, progress, timeout, self.time_is_up)
        # Closed at once on Ctrl-C, so that no worker outlives its run.
        with closing(outcomes):
            for index, outcome in outcomes:
                if isinstance(outcome, Done) and outcome.left is not None:
                    self._left[self._name(jobs[keys[index]])] = outcome.left
                yield _answer(keys[index], jobs[keys[index]], outcome)

    def _stands(self, evaluation: Evaluation) -> bool:
        """Return whether an evaluation is done; a fault of ours in an earlier process is not."""
        return evaluation.status is not Status.FAILED or evaluation.key in self._failed

    def _keep_policy(self, evaluation: Evaluation, policy: bytes) -> Evaluation:
        """Write the policy into the run's folder, whole or not at all; return where it is."""
        if not policy:
            return evaluation
        files, artifact = self.folder.files, f"{self.folder.artifacts.name}/{evaluation.key}"
        files.remove(f"{artifact}.partial")
        files.make(f"{artifact}.partial")
        files.write(f"{artifact}.partial/{POLICY}", policy)
        files.replace(f"{artifact}.partial", artifact)
        return replace(evaluation, artifact=evaluation.key)

    def _request(self, key: str, job: Job, leave_checkpoint: bool) -> Request:
        checkpoint = self._checkpoint(job)
        files = self.folder.files
        continues = leave_checkpoint or files.kind(checkpoint) == "folder"
        files.make(self.folder.scratch.name)
        if continues:
            files.make(checkpoint)
            files.check(checkpoint)
        return Request(
            job=job,
            key=key,
            scratch=str(self.folder.scratch / key),
            checkpoint=str(self.folder.path / checkpoint) if continues else "",
            containment=self.containment,
            versions=self.versions,
            task=task_content(self.task),
        )

    def _remote_request(self, key: str, job: Job, carry: Carry | None) -> Request:
        """Return a request for a worker that may share no disk with this process."""
        return Request(
            job=job,
            key=key,
            scratch="",
            checkpoint=carry.name if carry else "",
            containment=self.containment,
            versions=self.versions,
            task=task_content(self.task),
        )

    def _carry(self, job: Job, leave: bool) -> Carry | None:
        name = self._name(job)
        if not leave and name not in self._left:
            return None
        return Carry(name, self._left.get(name), leave)

    def _name(self, job: Job) -> str:
        return training_key(job, self.versions)

    def _checkpoint(self, job: Job) -> str:
        """Return where in the run's folder a training rests between two shares of its steps."""
        return f"{self.folder.checkpoints.name}/{self._name(job)}"

    def _drop_checkpoints(self, but: Sequence[Job]) -> None:
        wanted = {self._checkpoint(job) for job in but}
        names = {self._name(job) for job in but}
        self._left = {name: left for name, left in self._left.items() if name in names}
        folder = self.folder.checkpoints.name
        for name in self.folder.files.names(folder):
            if f"{folder}/{name}" not in wanted:
                self._discard(f"{folder}/{name}")

    def _discard(self, name: str) -> None:
        try:
            self.folder.files.remove(name)
        except OSError as error:
            log.warning("%s cannot be removed (%s)", self.folder.path / name, error.strerror)

    def _job(self, trial: Trial, budget: Budget, budget_fraction: float) -> Job:
        parameters, source = trial.design.morphology.parameters, trial.design.reward.source
        return make_job(
            self.task,
            trial.design,
            self.trainer,
            replace(budget, steps=round(budget_fraction * budget.steps)),
            derive_seed(self.seed, content_key(parameters, source), trial.place.repeat),
        )


def make_job(
    task: Task, design: Design, trainer: TrainerSettings, budget: Budget, seed: int
) -> Job:
    """Return a job with everything in it that decides its numbers.

    Args:
        task: what the design is measured in.
        design: what is trained.
        trainer: how, but for what is tuned to the robot.
        budget: of this evaluation.
        seed: of training and measuring.
    """
    return Job(
        task=task.id,
        design=design,
        trainer=resolve(trainer, task),
        steps=budget.steps,
        episodes=budget.episodes,
        seed=seed,
        limits=Limits.for_steps(budget.steps),
        task_key=task_key(task),
    )


def _answer(key: str, job: Job, outcome: Outcome) -> tuple[Evaluation, bytes]:
    if isinstance(outcome, Failed):
        if outcome.unstarted:
            raise NoWorker(
                f"{outcome.reason}; the same command goes on once it can, and everything that was "
                "finished is kept"
            )
        status = Status.TIMED_OUT if outcome.timed_out else Status.CRASHED
        return Evaluation(key, job, status, outcome.reason), b""
    try:
        answer = checked_answer(outcome.reply, key, job)
    except ValueError as error:
        # A worker may be anybody's, and what it sent stands in the reason.
        said = f"the worker's answer cannot be read: {one_line(str(error)[:_LONGEST])}"
        return Evaluation(key, job, Status.FAILED, said), b""
    return answer.evaluation, answer.policy
