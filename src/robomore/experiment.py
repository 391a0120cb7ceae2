"""The composition root: the one module that knows all concrete classes and puts a run together."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import msgspec

from robomore.designers import Designer, LanguageModel, Replay, make_designer
from robomore.designers.llm.designer import LLMDesigner, LLMSettings
from robomore.designers.recorded import RecordedDesigner
from robomore.errors import InputError, Interrupted
from robomore.evaluation.evaluate import evaluate as evaluate_request
from robomore.evaluation.evaluator import Evaluator
from robomore.evaluation.request import Request
from robomore.events import Observer, RunBegan, Spent, ignore, one_at_a_time
from robomore.executors import Processes, Threads
from robomore.identity import job_key
from robomore.llm import BudgetedClient, MemoryLog, ReplayModel, Spending
from robomore.rendering.snapshots import pictures
from robomore.report import write_report
from robomore.rewards.dry_run import DryRun
from robomore.sandbox.call import Containment
from robomore.sandbox.layers import ensure
from robomore.sandbox.restrictions import Layer, missing
from robomore.search import final, robomore
from robomore.settings import RunSettings, preset
from robomore.store import LedgerExchanges, Manifest, RunFolder, open_or_recover, package_versions
from robomore.store.champion import save_champion
from robomore.tasks import Task, get_task
from robomore.training.settings import ensure_trainer, packages_for
from robomore.types import Design, Evaluation, Job, Limits, Morphology, Reward

log = logging.getLogger(__name__)


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
    designer: str | LanguageModel | Replay = "offline",
    seed: int = 0,
    workers: int | None = None,
    out: str | Path | None = None,
    containment: str | None = None,
    observe: Observer = ignore,
    name: str = "",
) -> RunResult:
    """Search for the best body and reward for a task; the same call again finishes what is missing.

    Args:
        task: a task or its id.
        settings: a preset's name, or settings of your own.
        designer: who proposes: a name (`robomore.designers.DESIGNERS`), a language model, or what
            one said in another run.
        seed: same seed, same result, whatever the number of workers.
        workers: processes to train in, one a core by default.
        out: the run's folder; by default `runs/TASK-PRESET-DESIGNER-sSEED`.
        containment: `strict` refuses to start where the operating system lacks a layer that keeps
            a stranger's code in; `relaxed` uses the layers there are. By default strict, but for
            rewards of our own (a designer without a language model) where it is not possible.
        observe: told what goes on.
        name: of the settings in the manifest; by default the preset's, or `custom`.

    Raises:
        InputError: something asked for cannot be done; nothing was started.
        NothingTrained: every candidate failed.
        BudgetExhausted, ModelUnavailable: of a language model; the same call goes on later.
        Interrupted: Ctrl-C; the same call goes on where this one stopped.
    """
    task = get_task(task) if isinstance(task, str) else task
    observe = one_at_a_time(observe)
    name = name or (settings if isinstance(settings, str) else "custom")
    workers = workers or available_cores()
    settings = preset(settings) if isinstance(settings, str) else settings
    ensure_trainer(settings.trainer, min(settings.candidate.steps, settings.final.steps))
    objective = settings.search.objective
    mode, layers = _containment(containment, ours=designer in _OURS)
    chosen = _chosen(designer, task, seed, objective, mode, observe)
    manifest = Manifest(
        *(task.id, task.version, name, chosen.name, chosen.provenance, seed, settings),
        designer_settings=chosen.settings,
        versions=package_versions(*packages_for(settings.trainer)),
    )
    out = Path(out) if out else Path("runs") / f"{task.id}-{name}-{chosen.name}-s{seed}"

    with ExitStack() as stack:
        folder = RunFolder.prepare(out, manifest)
        stack.callback(folder.release)
        ledger = stack.enter_context(closing(open_or_recover(folder.ledger)))
        began = (task.id, name, settings, chosen.name, chosen.provenance, seed, workers, out)
        observe(RunBegan(*began, layers))
        executor = stack.enter_context(closing(Processes(workers)))
        evaluator = Evaluator(
            task.id,
            settings.trainer,
            seed,
            manifest.versions,
            ledger,
            folder,
            executor,
            containment=mode,
            observe=observe,
        )
        recorded = RecordedDesigner(chosen.make(folder, stack), ledger, observe)
        human = Design(Morphology(task.human, "the official robot"), Reward(task.reward))
        try:
            best = robomore(
                recorded,
                partial(evaluator.measure, budget=settings.candidate),
                settings.search,
                human.reward,
                ledger.noting(observe),
                Threads(chosen.parallel),
            )
            outcome = final(
                partial(evaluator.measure, budget=settings.final),
                [evaluation.design for evaluation in best[: settings.search.finalists]],
                human,
                settings.search.repeats,
                objective,
            )
            evaluator.restore_policies(outcome.champion)
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
    containment: str | None = None,
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
        containment: `strict` (the default) or `relaxed`, see `run`.
        progress: told the control steps of training done.

    Raises:
        InvalidMorphology: the parameters are refused.
        InputError: a setting cannot be used.
    """
    task = get_task(task) if isinstance(task, str) else task
    settings = preset(settings) if isinstance(settings, str) else settings
    ensure_trainer(settings.trainer, settings.candidate.steps if steps is None else steps)
    mode, _ = _containment(containment, ours=reward is None)
    if artifact is not None and artifact.exists() and any(artifact.iterdir()):
        raise InputError(f"{artifact} is not empty; name a new folder for the policy")
    checked = task.check(task.human if parameters is None else parameters)
    job = Job(
        task=task.id,
        design=Design(Morphology(checked), Reward(task.reward if reward is None else reward)),
        trainer=settings.trainer,
        steps=settings.candidate.steps if steps is None else steps,
        episodes=settings.candidate.episodes,
        seed=seed,
        limits=Limits.for_steps(settings.candidate.steps if steps is None else steps),
    )
    with TemporaryDirectory(prefix="robomore-") as scratch:
        request = Request(
            job=job,
            key=job_key(job, package_versions(*packages_for(settings.trainer))),
            scratch=str(Path(scratch) / "scratch"),
            artifact=str(artifact or ""),
            checkpoint=str(checkpoint or ""),
            containment=mode,
        )
        return evaluate_request(request, progress)


@dataclass(frozen=True, slots=True)
class _Chosen:
    """A designer that is known by its settings, and is made once the run's folder is there."""

    name: str
    provenance: str
    make: Callable[[RunFolder, ExitStack], Designer]
    settings: dict[str, Any] = field(default_factory=dict)
    parallel: int = 1


def _chosen(
    designer: str | LanguageModel | Replay,
    task: Task,
    seed: int,
    objective: str,
    containment: Containment,
    observe: Observer,
) -> _Chosen:
    if isinstance(designer, str):
        made = make_designer(designer, task, seed, objective)
        return _Chosen(designer, made.provenance, lambda folder, stack: made)
    model = _recorded(designer) if isinstance(designer, Replay) else designer
    # Before anything is written, refuse a limit that cannot be kept.
    BudgetedClient(model.model, MemoryLog(), model.budget)

    def watch(spent: Spending) -> None:
        dollars = None if spent.unpriced else spent.cost
        observe(Spent(spent.requests, spent.tokens, dollars))

    def make(folder: RunFolder, stack: ExitStack) -> Designer:
        log = stack.enter_context(closing(LedgerExchanges(folder.ledger)))
        return LLMDesigner(
            task,
            BudgetedClient(model.model, log, model.budget, watch),
            model.settings,
            objective=objective,
            rehearse=DryRun(task, folder.scratch, containment),
            pictures=partial(_seen, task, folder.artifacts) if model.vision else None,
        )

    provenance = f"Proposed by a language model: {model.model.name}"
    if isinstance(designer, Replay):
        identity = {**model.identity, "replayed": designer.by}
        return _Chosen(Replay.name, f"{provenance}, as recorded in {designer.run}.", make, identity)
    return _Chosen(LanguageModel.name, f"{provenance}.", make, model.identity, model.parallel)


_OURS = ("offline", "human", "random")
"""Designers whose rewards are composed from this package's own text."""


def _containment(asked: str | None, ours: bool) -> tuple[Containment, str]:
    """Return how strangers' code is kept in, and by which layers, or refuse before anything starts.

    Raises:
        InputError: strict containment is asked for, or needed, and not possible here.
    """
    if asked is None and ours:
        found = ensure(Containment.RELAXED)
        possible = not missing(found)
        if not possible:
            log.warning("strict containment is not possible here; `robomore doctor` says why")
        return _told(Containment.STRICT if possible else Containment.RELAXED, found)
    mode = Containment(asked or Containment.STRICT)
    return _told(mode, ensure(mode))


def _told(mode: Containment, found: Sequence[Layer]) -> tuple[Containment, str]:
    on = ", ".join(layer.name for layer in found if layer.active)
    off = ", ".join(layer.name for layer in found if not layer.active)
    return mode, f"{mode} ({on}{f'; without {off}' if off else ''})"


def _recorded(replay: Replay) -> LanguageModel:
    """Return the model and the settings of a recorded run.

    Raises:
        InputError: no language model designed that run.
    """
    folder = RunFolder.existing(replay.run)
    manifest = Manifest.load(folder.manifest)
    settings = manifest.designer_settings
    if "model" not in settings:
        raise InputError(
            f"{replay.run} was designed by {manifest.designer!r}; name the run of a language model"
        )
    with closing(LedgerExchanges(folder.ledger, read_only=True)) as log:
        model = ReplayModel(log, replay.by)
    try:
        used = msgspec.convert(settings, LLMSettings)
    except msgspec.ValidationError as error:
        raise InputError(f"{folder.manifest} is damaged ({error}); name another run") from None
    return LanguageModel(
        model, used, vision=bool(settings.get("vision")), server=str(settings.get("server", ""))
    )


def _seen(task: Task, artifacts: Path, evaluation: Evaluation) -> list[bytes]:
    return pictures(task, evaluation, artifacts)


def available_cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
