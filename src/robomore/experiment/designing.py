"""Who designs in a run: known by its settings at once, made when the run's folder is there."""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import msgspec

from robomore.designers import Designer, LanguageModel, Replay, make_designer
from robomore.designers.llm.designer import LLMDesigner, LLMSettings
from robomore.designers.llm.training_facts import TrainingFacts
from robomore.errors import InputError
from robomore.events import Observer, Spent, Waiting
from robomore.llm import BudgetedClient, MemoryLog, ReplayModel, Spending
from robomore.rendering.snapshots import pictures
from robomore.rewards.dry_run import DryRun
from robomore.sandbox.call import Containment
from robomore.store import Ledger, LedgerExchanges, Manifest, RunFolder
from robomore.tasks import Task
from robomore.training.policy import POLICY, MLPPolicy
from robomore.types import Curve, Evaluation, Slot

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ChosenDesigner:
    """A designer that is known by its settings.

    Attributes:
        name: as on the command line; empty for a method that asks no designer.
        provenance: one plain sentence on what makes the proposals.
        make: makes it, once the run's folder is there.
        settings: what decides its proposals, as plain data.
        parallel: proposals that may be asked for at once.
        reads_hints: whether it reads a person's remarks.
    """

    name: str
    provenance: str
    make: Callable[[RunFolder, ExitStack], Designer]
    settings: dict[str, Any] = field(default_factory=dict)
    parallel: int = 1
    reads_hints: bool = False


def choose_designer(
    designer: str | LanguageModel | Replay,
    task: Task,
    seed: int,
    objective: str,
    containment: Containment,
    observe: Observer,
    training: TrainingFacts | None = None,
) -> ChosenDesigner:
    """Return the designer that was asked for, or refuse before anything is written.

    Args:
        designer: a name, a language model, or what one said in another run.
        task: what is designed for.
        seed: of the run.
        objective: what the search compares.
        containment: how a reward is kept in while it is tried.
        observe: told what a language model has cost.
        training: what a language model is told of how designs are trained.

    Raises:
        InputError: there is no such designer, or one of its settings cannot be used.
    """
    if isinstance(designer, str):
        made = make_designer(designer, task, seed, objective)
        reads = hasattr(made, "with_hint")
        return ChosenDesigner(
            designer, made.provenance, lambda folder, stack: made, reads_hints=reads
        )
    model = _recorded(designer) if isinstance(designer, Replay) else designer
    name, identity = _identity(designer, model)
    # Before anything is written, refuse a limit that cannot be kept.
    BudgetedClient(model.model, MemoryLog(), model.budget)

    def watch(spent: Spending) -> None:
        dollars = None if spent.unpriced else spent.cost
        observe(Spent(spent.requests, spent.tokens, dollars))

    def waits(slot: Slot, waiting: bool) -> None:
        observe(Waiting(slot, over=not waiting))

    def make(folder: RunFolder, stack: ExitStack) -> Designer:
        log = stack.enter_context(closing(LedgerExchanges(folder.ledger)))
        return LLMDesigner(
            task,
            BudgetedClient(model.model, log, model.budget, watch, waits),
            model.settings,
            objective=objective,
            dry_run=DryRun(task, folder.scratch, containment),
            pictures=partial(_pictures, task, folder.artifacts) if model.vision else None,
            training=training,
            curve_of=_Curves(folder, stack).curve,
        )

    provenance = f"Proposed by a language model: {model.model.name}"
    if isinstance(designer, Replay):
        said = f"{provenance}, as recorded in {designer.run}."
        return ChosenDesigner(name, said, make, identity, reads_hints=True)
    return ChosenDesigner(
        name, f"{provenance}.", make, identity, designer.parallel, reads_hints=True
    )


def designer_identity(
    designer: str | LanguageModel | Replay | None,
) -> tuple[str, dict[str, Any]]:
    """Return what a manifest says of a designer: its name, and what decides its proposals.

    Raises:
        InputError: what it is to repeat was not designed by a language model.
    """
    if designer is None:
        return "", {}
    if isinstance(designer, str):
        return designer, {}
    model = _recorded(designer) if isinstance(designer, Replay) else designer
    return _identity(designer, model)


def _identity(designer: LanguageModel | Replay, model: LanguageModel) -> tuple[str, dict[str, Any]]:
    if isinstance(designer, Replay):
        return Replay.name, {**model.identity, "replayed": designer.by}
    return LanguageModel.name, model.identity


class _Curves:
    """Learning curves from a run's ledger, which is opened when the first one is asked for."""

    def __init__(self, folder: RunFolder, stack: ExitStack) -> None:
        self._folder = folder
        self._stack = stack
        self._ledger: Ledger | None = None

    def curve(self, key: str) -> Curve | None:
        """Return the learning curve of the evaluation with that key."""
        if self._ledger is None:
            ledger = Ledger(self._folder.ledger, read_only=True)
            self._ledger = self._stack.enter_context(closing(ledger))
        return self._ledger.curve(key)


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


def _pictures(task: Task, artifacts: Path, evaluation: Evaluation) -> list[bytes]:
    """Return pictures of a measured design; how it moves only if its policy can be used."""
    parameters = evaluation.design.morphology.parameters
    if evaluation.artifact:
        try:
            act = MLPPolicy.load(artifacts / evaluation.artifact / POLICY).act
            return pictures(task, parameters, act, evaluation.job.seed)
        except (OSError, ValueError) as error:
            log.warning("no picture of how it moves: %s", error)
    return pictures(task, parameters)
