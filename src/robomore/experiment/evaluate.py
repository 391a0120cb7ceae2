"""One design, trained and measured, outside of any run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from robomore.errors import InputError
from robomore.evaluation.evaluate import evaluate as answer
from robomore.evaluation.evaluator import make_job
from robomore.evaluation.request import Request
from robomore.experiment.arguments import ensure_whole
from robomore.experiment.containing import choose_containment
from robomore.identity import job_key, training_key
from robomore.settings import Budget, RunSettings, preset
from robomore.tasks import Task, get_task
from robomore.tasks.portable import task_content
from robomore.training.policy import POLICY
from robomore.training.settings import versions_for
from robomore.training.tuned import ensure_tuned
from robomore.types import Design, Evaluation, Morphology, Reward


def evaluate(
    task: str | Task,
    parameters: Sequence[float] | Mapping[str, float] | None = None,
    reward: str | None = None,
    settings: str | RunSettings = "quick",
    *,
    steps: int | None = None,
    seed: int = 0,
    artifact: Path | None = None,
    checkpoint: Path | None = None,
    containment: str | None = None,
    progress: Callable[[int], None] = lambda steps: None,
) -> Evaluation:
    """Train one design and measure it.

    Args:
        task: a task or its id.
        parameters: in the task's order or by name; the reference morphology by default.
        reward: source text; the reference reward by default.
        settings: preset or settings whose trainer and candidate budget are used.
        steps: control steps of training, instead of the preset's.
        seed: of training and measuring.
        artifact: folder to leave the policy in.
        checkpoint: folder to continue training from, and to leave a checkpoint in. Every training
            (task, design, trainer, seed and versions) has a folder of its own in it, so that it is
            continued by the same one alone, with any number of steps.
        containment: `strict` (the default) or `relaxed`, see `run`.
        progress: told the control steps of training done.

    Raises:
        InvalidMorphology: the parameters are refused.
        InputError: a setting cannot be used.
    """
    task = get_task(task) if isinstance(task, str) else task
    settings = preset(settings) if isinstance(settings, str) else settings
    ensure_whole("the seed", seed, 0)
    if steps is not None:
        ensure_whole("the number of steps", steps, 1)
    budget = Budget(steps or settings.candidate.steps, settings.candidate.episodes)
    ensure_tuned(settings.trainer, task, budget.steps)
    mode, _ = choose_containment(containment, ours=reward is None)
    if artifact is not None and artifact.exists() and any(artifact.iterdir()):
        raise InputError(f"{artifact} is not empty; name a new folder for the policy")
    checked = task.check(task.reference if parameters is None else parameters)
    design = Design(Morphology(checked), Reward(task.reward if reward is None else reward))
    job = make_job(task, design, settings.trainer, budget, seed)
    versions = versions_for(settings.trainer)
    resting = Path(checkpoint) / training_key(job, versions) if checkpoint else ""
    with TemporaryDirectory(prefix="robomore-") as scratch:
        request = Request(
            job=job,
            key=job_key(job, versions),
            scratch=str(Path(scratch) / "scratch"),
            checkpoint=str(resting),
            containment=mode,
            task=task_content(task),
        )
        answered = answer(request, progress)
    if artifact is not None and answered.policy:
        artifact.mkdir(parents=True, exist_ok=True)
        (artifact / POLICY).write_bytes(answered.policy)
    return answered.evaluation
