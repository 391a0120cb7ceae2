"""A search from beginning to end: put together, run to a budget, compared, and written down."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack, closing, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path

from robomore.designers import LanguageModel, Replay
from robomore.designers.absent import NoDesigner
from robomore.designers.hints import Hints, no_hint
from robomore.designers.recorded import RecordedDesigner
from robomore.designers.started import StartedDesigner
from robomore.errors import (
    InputError,
    Interrupted,
    NothingTrained,
    StorageFailed,
    TimeLimitReached,
)
from robomore.evaluation.evaluator import Evaluator
from robomore.events import Observer, RunBegan, both, ignore, one_at_a_time
from robomore.executors import EXECUTORS, Executor, thread_map
from robomore.experiment.arguments import (
    ensure_settings,
    ensure_usable,
    refuse_useless,
    warn_of_size,
)
from robomore.experiment.auditing import doubt, no_doubt
from robomore.experiment.containing import choose_containment
from robomore.experiment.designing import ChosenDesigner, choose_designer
from robomore.experiment.first_look import refuse_untrained
from robomore.experiment.limits import limited, refusal
from robomore.experiment.noting import note_budget, note_final
from robomore.experiment.starting import Given, checked_starts, try_rewards
from robomore.experiment.training_facts import training_facts
from robomore.identity import content_key
from robomore.monitor.progress import ProgressFile
from robomore.plan import Plan
from robomore.report.page import render
from robomore.runs import Run, load_run
from robomore.sandbox.call import Containment
from robomore.search import SearchContext, SearchMethod, final, make_method
from robomore.search.budget import BudgetedEvaluate, BudgetSpent
from robomore.search.final import stage as final_stage
from robomore.search.measure import distinct
from robomore.search.starts import usable
from robomore.settings import RunSettings, preset
from robomore.store import Manifest, RunFolder, open_or_recover
from robomore.store.champion import save_champion
from robomore.tasks import Task, get_task
from robomore.tasks.fingerprint import fingerprint
from robomore.tasks.portable import task_content
from robomore.tasks.registry import remember
from robomore.trackers import RunTracking
from robomore.training.settings import versions_for
from robomore.training.tuned import ensure_tuned
from robomore.types import Design, Evaluation, Morphology, Reward, Start


def run(
    task: str | Task,
    settings: str | RunSettings = "quick",
    *,
    designer: str | LanguageModel | Replay | None = None,
    seed: int = 0,
    executor: str | Executor = "processes",
    workers: int | None = None,
    out: str | Path | None = None,
    budget_steps: int | None = None,
    time_limit: float | None = None,
    containment: str | None = None,
    observe: Observer = ignore,
    trackers: Sequence[str] = (),
    name: str = "",
    start_from: Sequence[Given] = (),
    hint: str = "",
) -> Run:
    """Search for the best morphology and reward; the same call again finishes what is missing.

    Args:
        task: a task or its id.
        settings: a preset's name, or settings of your own (`robomore.settings`), the search method
            and the trainer among them.
        designer: who proposes: a name, a language model, or what one said in another run; by
            default the offline designer, if the method asks one at all.
        seed: same seed, same result, whatever the number of workers.
        executor: where evaluations run: `processes`, `inline` in this process, or `ray` on this
            machine; or an executor of your own making, which is left open
            (`robomore.executors.ray.Ray` for a cluster).
        workers: evaluations side by side, one a core by default. An executor of your own making
            knows its own number.
        out: the run's folder; by default `runs/TASK-SETTINGS-DESIGNER-sSEED`, with a
            digest of what it starts from, if anything.
        budget_steps: control steps of training that the search may use; the final comes on top.
            The same call with a larger budget goes on; one below what was spent is refused.
        time_limit: wall-clock seconds after which nothing new is started. The run then ends with
            the best so far, and the same call goes on.
        containment: `strict` refuses to start where the operating system lacks a layer that keeps
            untrusted code in; `relaxed` uses the layers there are. By default strict, but for
            rewards of our own (no language model) where it is not possible.
        observe: told what goes on.
        trackers: names of trackers that are told the numbers: `tensorboard`, `wandb`, `trackio`.
        name: of the settings in the manifest; by default the preset's, or `custom`.
        start_from: morphologies, rewards, designs, or runs whose champion is meant. They take the
            first places of the search, and are part of its identity.
        hint: your remark for a designer that reads one. More can be written into `hint.txt` in the
            run's folder while the run goes on. The ledger keeps which proposal had which remark.

    Raises:
        InputError: something asked for cannot be done; nothing was started.
        StorageFailed: the disk is full, or cannot be written; what was finished is kept.
        NothingTrained: every candidate failed.
        BudgetExhausted, ModelUnavailable: of a language model; the same call goes on later.
        Interrupted: Ctrl-C; the same call goes on where this one stopped.
    """
    began = time.monotonic()
    ensure_usable(seed, workers, budget_steps, time_limit, out)
    task = get_task(task) if isinstance(task, str) else task
    content = task_content(task)
    if content:
        remember(task)
    tracking = RunTracking(trackers)
    observe = one_at_a_time(both(observe, tracking))
    name = name or (settings if isinstance(settings, str) else "custom")
    settings = preset(settings) if isinstance(settings, str) else settings
    ensure_settings(settings)
    method = make_method(settings.method)
    make_executor = _executor(executor, workers)
    ensure_tuned(settings.trainer, task, min(settings.candidate.steps, settings.final.steps))
    refuse_useless(task, settings, method, designer, budget_steps)
    # Search and designer know the limits as rules; a worker knows the task as it is.
    draws = "morphology" in getattr(method, "starts_from", ()) and designer in (None, "offline")
    searched = limited(task, settings, draws=draws)
    starts = checked_starts(searched, start_from)
    # A reward that comes from elsewhere is untrusted, whoever proposes it.
    given = [(one.origin, one.reward.source) for one in starts if one.reward]
    if source := settings.method.options.get("reward"):
        given.append((f"the option `reward` of {settings.method.name!r}", source))
    ours = designer in (None, "offline") and all(one == task.reward for _, one in given)
    mode, layers = choose_containment(containment, ours=ours)
    chosen = _no_designer(method)
    if method.needs_designer:
        proposing = designer or "offline"
        facts = training_facts(settings, task)
        chosen = choose_designer(
            proposing, searched, seed, settings.objective, mode, observe, facts
        )
    context = SearchContext(
        task=searched,
        reference=Design(
            Morphology(task.reference, "the reference design"),
            Reward(task.reward, "the reference reward"),
        ),
        candidate=settings.candidate,
        evaluations=settings.evaluations,
        objective=settings.objective,
        seed=seed,
        map_fn=thread_map(chosen.parallel),
    )
    if hint.strip() and not chosen.reads_hints:
        raise InputError(
            f"{chosen.name or 'this method'} reads no remarks; leave the hint out, or choose a "
            "language model (--model)"
        )
    first_morphologies, first_rewards = usable(
        starts,
        getattr(method, "starts_from", ()),
        method.plan(context),
        settings.method.name,
        getattr(method, "reference_first", True),
    )
    if not method.needs_designer:
        context = replace(context, starts=first_morphologies)
    plan = Plan((*method.plan(context).stages, final_stage(settings.final)))
    refuse_untrained(task, settings, plan)
    warn_of_size(method, context, budget_steps)
    manifest = Manifest(
        task=task.id,
        task_parts=fingerprint(task),
        preset=name,
        designer=chosen.name,
        provenance=_provenance(chosen, method, starts),
        seed=seed,
        settings=settings,
        plan=plan,
        starts=starts,
        designer_settings=chosen.settings,
        versions=versions_for(settings.trainer),
    )
    out = (
        Path(out).expanduser() if out else default_folder(task.id, name, chosen.name, seed, starts)
    )

    if not RunFolder(out).manifest.exists():
        # Only then: a dry run measures time, so it could refuse tomorrow what it took today.
        trained = {source, *(reward.source for reward in first_rewards)}
        try_rewards(searched, [one for one in given if one[1] in trained], mode)

    def time_is_up() -> bool:
        return time_limit is not None and time.monotonic() - began >= time_limit

    with ExitStack() as stack:
        stack.callback(tracking.close)
        folder = RunFolder.prepare(out, manifest)
        stack.callback(folder.release)
        stack.callback(folder.empty_scratch)
        progress = ProgressFile(folder.progress, observe)
        stack.callback(progress.close)
        observe = one_at_a_time(progress)
        if content:
            folder.files.write(folder.task.name, content)
        ledger = stack.enter_context(closing(open_or_recover(folder.ledger)))
        note_budget(ledger, plan, budget_steps, out)
        if mode is Containment.RELAXED:
            ledger.add_event("containment", layers=layers)
        doing = stack.enter_context(make_executor())
        observe(
            RunBegan(
                task=task.id,
                preset=name,
                settings=settings,
                plan=plan,
                designer=chosen.name,
                provenance=manifest.provenance,
                seed=seed,
                workers=doing.workers,
                folder=out,
                containment=layers,
                budget_steps=budget_steps,
                time_limit=time_limit,
                fitness_unit=task.goal.unit,
            )
        )
        evaluator = Evaluator(
            task=task,
            trainer=settings.trainer,
            seed=seed,
            versions=manifest.versions,
            ledger=ledger,
            folder=folder,
            executor=doing,
            containment=mode,
            observe=observe,
            time_is_up=time_is_up,
            refusal=partial(refusal, searched),
        )
        asked = chosen.make(folder, stack)
        if starts:
            asked = StartedDesigner(asked, first_morphologies, first_rewards)
        hint_for = Hints(hint, folder, ledger).of if chosen.reads_hints else no_hint
        recorded = RecordedDesigner(asked, ledger, observe, time_is_up, hint_for)
        context = replace(context, observe=ledger.noting(observe))
        try:
            best = _search(method, recorded, evaluator, context, budget_steps)
            outcome = final(
                partial(evaluator.measure, budget=settings.final, refuse=False),
                distinct(best)[: settings.final.finalists],
                context.reference,
                settings.final.seeds,
                settings.objective,
                lambda morphology: not refusal(searched, morphology),
                partial(doubt, evaluator, task, settings.objective)
                if settings.final.require_audit
                else no_doubt,
            )
            evaluator.restore_policies(outcome.champion)
            save_champion(folder, task, outcome.champion, settings.objective)
            note_final(ledger, outcome)
        except KeyboardInterrupt:
            ledger.add_event("interrupted")
            raise Interrupted(
                f"stopped; {len(ledger.evaluations())} evaluations are kept in {out}, "
                "and the same command goes on from there"
            ) from None
        except TimeLimitReached:
            ledger.add_event("time-limit", seconds=time_limit)
        found = load_run(out)
        try:
            folder.files.write(folder.report.name, render(found).encode())
        except OSError as error:
            raise StorageFailed(
                f"everything that was measured is whole and kept in {out}, but its report cannot "
                f"be written ({error.strerror}); free disk space, then `robomore report {out}` "
                "writes it"
            ) from None
    return found


def _executor(
    asked: str | Executor, workers: int | None
) -> Callable[[], AbstractContextManager[Executor]]:
    """Return what makes the executor, or hands on the one that was given.

    Raises:
        InputError: no executor has that name.
    """
    if not isinstance(asked, str):
        return lambda: nullcontext(asked)
    make = EXECUTORS.get(asked)
    return lambda: closing(make(workers or available_cores()))


def _search(
    method: SearchMethod,
    designer: RecordedDesigner,
    evaluator: Evaluator,
    context: SearchContext,
    budget_steps: int | None,
) -> list[Evaluation]:
    """Return the method's designs, best first, and then what else it trained to the end; what was
    trained, best first, when its budget is spent.

    Raises:
        NothingTrained: there is none.
    """
    measure = partial(evaluator.measure, budget=context.candidate)
    evaluate = BudgetedEvaluate(measure, context.candidate, budget_steps)
    try:
        best = method.run(designer, evaluate, context)
        if best:
            # `robomore` ends with one design a branch, and the final may be asked for more.
            best = [*best, *evaluate.best(context.objective)]
    except BudgetSpent:
        best = evaluate.best(context.objective)
    except NothingTrained:
        # The method can go no further, and what was trained before is something.
        best = evaluate.best(context.objective)
        if not best:
            raise
    if not best:
        why = next((f"; for example: {e.diagnosis}" for e in evaluator.ledger.evaluations()), "")
        raise NothingTrained(f"the search trained no design that can be compared{why}")
    return best


def _no_designer(method: SearchMethod) -> ChosenDesigner:
    return ChosenDesigner(
        "", method.provenance, lambda folder, stack: NoDesigner(method.provenance)
    )


def _provenance(chosen: ChosenDesigner, method: SearchMethod, starts: Sequence[Start]) -> str:
    """Return in plain sentences what made the designs, and what they started from."""
    origins = ", ".join(start.origin for start in starts)
    begun = f"It started from {origins}." if starts else ""
    return " ".join(
        said for said in (chosen.provenance, getattr(method, "adds", ""), begun) if said
    )


def default_folder(
    task: str, name: str, designer: str, seed: int, starts: Sequence[Start] = ()
) -> Path:
    """Return the folder of a run that was given none: named after all that was asked for."""
    # Without the digest, the run without starts would be refused in the folder of the one with.
    digest = content_key(*(one.content for one in starts))[:6] if starts else ""
    parts = task, name, designer, f"from-{digest}" if digest else "", f"s{seed}"
    return Path("runs") / "-".join(part for part in parts if part)


def available_cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
