"""The composition root: the one module that knows all concrete classes and puts a run together."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from robomore.designers import make_designer
from robomore.designers.recorded import RecordedDesigner
from robomore.errors import Interrupted
from robomore.evaluation.evaluate import evaluate as evaluate_request
from robomore.evaluation.evaluator import Evaluator
from robomore.evaluation.request import Request
from robomore.events import Observer, RunBegan, ignore
from robomore.executors import Processes
from robomore.identity import job_key
from robomore.report import write_report
from robomore.search import final, robomore
from robomore.settings import RunSettings, preset
from robomore.store import Ledger, Manifest, RunFolder, package_versions
from robomore.store.champion import save_champion
from robomore.tasks import Task, get_task
from robomore.types import Design, Evaluation, Job, Morphology, Reward


@dataclass(frozen=True, slots=True)
class RunResult:
    """What a run ended with.

    Attributes:
        folder: where everything about it lies.
        champion: the winner, retrained once per seed.
        human: the human design, retrained alike.
    """

    folder: Path
    champion: tuple[Evaluation, ...]
    human: tuple[Evaluation, ...]


def run(
    task: str | Task,
    settings: str | RunSettings = "quick",
    designer: str = "offline",
    seed: int = 0,
    workers: int | None = None,
    out: str | Path | None = None,
    containment: str = "strict",
    observe: Observer = ignore,
    name: str = "",
) -> RunResult:
    """Search for the best body and reward for a task; the same call again finishes what is missing.

    Args:
        task: a task or its id.
        settings: a preset's name, or settings of your own.
        designer: who proposes (`robomore.designers.DESIGNERS`).
        seed: same seed, same result, whatever the number of workers.
        workers: processes to train in, one a core by default.
        out: the run's folder; by default `runs/TASK-PRESET-DESIGNER-sSEED`.
        containment: `strict` refuses to run rewards without the operating system's layers.
        observe: told what goes on.
        name: of the settings in the manifest; by default the preset's, or `custom`.

    Raises:
        InputError: something asked for cannot be done; nothing was started.
        NothingTrained: every candidate failed.
        Interrupted: Ctrl-C; the same call goes on where this one stopped.
    """
    task = get_task(task) if isinstance(task, str) else task
    name = name or (settings if isinstance(settings, str) else "custom")
    workers = workers or available_cores()
    settings = preset(settings) if isinstance(settings, str) else settings
    objective = settings.search.objective
    proposing = make_designer(designer, task, seed, objective)
    manifest = Manifest(task.id, task.version, name, designer, proposing.provenance, seed, settings)
    out = Path(out) if out else Path("runs") / f"{task.id}-{name}-{designer}-s{seed}"

    with ExitStack() as stack:
        folder = RunFolder.prepare(out, manifest)
        stack.callback(folder.release)
        ledger = stack.enter_context(closing(Ledger(folder.ledger)))
        observe(
            RunBegan(task.id, name, settings, designer, proposing.provenance, seed, workers, out)
        )
        executor = stack.enter_context(closing(Processes(workers)))
        evaluator = Evaluator(
            task.id,
            settings.trainer,
            seed,
            manifest.versions,
            ledger,
            folder,
            executor,
            containment=containment,
            observe=observe,
        )
        recorded = RecordedDesigner(proposing, ledger, observe)
        human = Design(Morphology(task.human, "the official robot"), Reward(task.reward))
        try:
            best = robomore(
                recorded,
                partial(evaluator.measure, budget=settings.candidate),
                settings.search,
            )
            outcome = final(
                partial(evaluator.measure, budget=settings.final),
                [evaluation.design for evaluation in best[: settings.search.finalists]],
                human,
                settings.search.repeats,
                objective,
            )
        except KeyboardInterrupt:
            ledger.add_event("interrupted")
            raise Interrupted(
                f"stopped; {len(ledger.evaluations())} evaluations are kept in {out}, "
                "and the same command goes on from there"
            ) from None
        save_champion(folder, task, outcome.champion, objective)
        ledger.add_event("finished", champion=[evaluation.key for evaluation in outcome.champion])
        write_report(out)
    return RunResult(out, outcome.champion, outcome.human)


def evaluate(
    task: str | Task,
    parameters: Sequence[float] | Mapping[str, float] | None = None,
    reward: str | None = None,
    settings: str | RunSettings = "quick",
    steps: int | None = None,
    seed: int = 0,
    artifact: Path | None = None,
    checkpoint: Path | None = None,
    containment: str = "strict",
    progress: Callable[[int], None] = lambda steps: None,
) -> Evaluation:
    """Train one design and measure it.

    Args:
        task: a task or its id.
        parameters: in the task's order or by name; the human design's by default.
        reward: source text; the reference reward by default.
        settings: preset or settings whose trainer and candidate budget are used.
        steps: control steps of training, instead of the preset's.
        seed: of training and measuring.
        artifact: folder to leave the policy in.
        checkpoint: folder to continue training from, and to leave a checkpoint in.
        containment: `strict` refuses to run rewards without the operating system's layers.
        progress: told the control steps of training done.

    Raises:
        InvalidMorphology: the parameters are refused.
        InputError: a setting cannot be used.
    """
    task = get_task(task) if isinstance(task, str) else task
    settings = preset(settings) if isinstance(settings, str) else settings
    checked = task.check(task.human if parameters is None else parameters)
    job = Job(
        task=task.id,
        design=Design(Morphology(checked), Reward(task.reward if reward is None else reward)),
        trainer=settings.trainer,
        steps=settings.candidate.steps if steps is None else steps,
        episodes=settings.candidate.episodes,
        seed=seed,
    )
    with TemporaryDirectory(prefix="robomore-") as scratch:
        request = Request(
            job=job,
            key=job_key(job, package_versions()),
            scratch=str(Path(scratch) / "scratch"),
            artifact=str(artifact or ""),
            checkpoint=str(checkpoint or ""),
            containment=containment,
        )
        return evaluate_request(request, progress)


def available_cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
