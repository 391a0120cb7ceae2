"""From a run's folder to a `Run`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from statistics import fmean
from typing import Any

from robomore.errors import InputError, RunFolderError
from robomore.importer.first_compile import compile_content
from robomore.plain_files import PlainFolder
from robomore.plan import Plan
from robomore.runs.empty import empty_slots
from robomore.runs.lineage import Record, best_of
from robomore.runs.run import Run
from robomore.runs.trained import TrainedDesign, trained_design
from robomore.runs.words import in_unit
from robomore.store import Ledger, LedgerExchanges, Manifest, RunFolder
from robomore.store.rundir import TASK_CONTENT
from robomore.tasks import Task
from robomore.tasks.fingerprint import fingerprint
from robomore.tasks.portable import MOST_CONTENT, task_from_content
from robomore.tasks.registry import known_task, refuse_taken
from robomore.text import one_line, to_json
from robomore.types import Evaluation, Place

ROLES = ("champion", "reference", "found", "morphology_only", "reward_only")
"""Groups of the final, as a run's last event names them."""


def load_run(folder: str | Path) -> Run:
    """Read a run folder; the run may still go on.

    Raises:
        RunFolderError: it is no run folder.
        LedgerError: its ledger is damaged.
        InputError: its task is not installed here, or has other parameters now.
    """
    path = Path(folder).expanduser()
    files = RunFolder.existing(path)
    manifest = Manifest.load(files.manifest)
    task = stored_task(files.files, manifest.task)
    if not files.ledger.is_file():
        raise RunFolderError(f"{path} has no ledger; start its run again with the same command")
    with closing(Ledger(files.ledger, read_only=True)) as ledger:
        placed = ledger.placed()
        measured = tuple(ledger.evaluations())
        untried = {cut.place: cut.reason for cut in ledger.cuts() if not cut.steps}
        proposals = tuple(ledger.proposals())
        events = ledger.events()
    # A final is no last word once its search goes on with another budget.
    since = max((n for n, event in enumerate(events) if event.kind == "budget"), default=0)
    ends = [event for event in events[since:] if event.kind == "finished"]
    budgets = [event.body.get("steps") for event in events if event.kind == "budget"]
    relaxed = [event.body.get("layers") for event in events if event.kind == "containment"]
    with closing(LedgerExchanges(files.ledger, read_only=True)) as exchanges:
        spending = exchanges.spent()
    plan = manifest.plan
    _refuse_misfits(path, plan, [*(place for place, _ in placed), *untried])
    placed, measured = _without_earlier_finals(
        plan, placed, measured, ends[-1].body if ends else {}
    )
    records = tuple(
        # A resumed run asks again from the start, so the ledger's own order may be half old.
        sorted((Record(*pair) for pair in placed), key=lambda record: plan.position(record.place))
    )
    if any(len(r.evaluation.design.morphology.parameters) != len(task.names) for r in records):
        raise InputError(
            f"{path} was made with other parameters of the task {task.id} than it has now; "
            "install the version of the task that the run was made with"
        )
    groups = _groups(task, records, ends[-1].body if ends else {})
    champion = groups.get("champion")
    run = Run(
        folder=path,
        manifest=manifest,
        task=task,
        final=champion is not None,
        champion=champion,
        champion_role=_role(groups),
        found=groups.get("found"),
        reference=groups.get("reference"),
        morphology_only=groups.get("morphology_only"),
        reward_only=groups.get("reward_only"),
        records=records,
        measured=measured,
        untried=untried,
        proposals=proposals,
        empty=empty_slots(proposals, plan),
        spending=spending,
        task_changes=_changes(manifest.task_parts, fingerprint(task)),
        passed_over=_passed_over(task, records, manifest, ends[-1].body if ends else {}),
        containment=one_line(str(relaxed[-1])) if relaxed else "",
        budget_steps=budgets[-1] if budgets and isinstance(budgets[-1], int) else None,
    )
    if champion is None and (best := best_of((r.evaluation for r in run.searched), run.objective)):
        return replace(run, champion=trained_design("best so far", task, [best]))
    return run


def _refuse_misfits(folder: Path, plan: Plan, places: Iterable[Place]) -> None:
    """Refuse a run whose manifest and ledger are not of one search.

    Raises:
        RunFolderError: a place has other numbers than the axes of its stage.
    """
    for place in places:
        axes = plan.stage(place.stage).axes
        if axes and len(place.index) != len(axes):
            raise RunFolderError(
                f"{folder} has an evaluation with {len(place.index)} numbers in the stage "
                f"{place.stage[:50]!r}, whose axes are {', '.join(axes)[:100]}; its run.json and "
                "its ledger are not of one run: restore both from one copy"
            )


def stored_task(files: PlainFolder, id: str) -> Task:
    """Return the task whose content stands in a folder, or else the installed one of that id.

    Raises:
        InputError: there is none, its content is damaged, it has the id of an installed task, or
            MuJoCo needs too much to compile it.
    """
    if files.is_file(TASK_CONTENT):
        content = files.read(TASK_CONTENT, MOST_CONTENT)
        task = task_from_content(content, trusted=False)
        compile_content(content)
        refuse_taken(task)
        return task
    return known_task(id)


def _without_earlier_finals(
    plan: Plan,
    placed: Sequence[tuple[Place, Evaluation]],
    measured: tuple[Evaluation, ...],
    finished: dict[str, Any],
) -> tuple[list[tuple[Place, Evaluation]], tuple[Evaluation, ...]]:
    """Leave out what the final of a smaller budget asked for, and the last final did not.

    It stays in the ledger, but two finals in one table would be read as one.
    """
    places = finished.get("places")
    if not isinstance(places, list):  # of a run from before finals named them
        return list(placed), measured
    last = {str(place): number for number, place in enumerate(places)}
    search, final = [], []
    for place, evaluation in placed:
        if plan.stage(place.stage).role != "final":
            search.append((place, evaluation))
        elif (number := last.get(to_json(place).decode())) is not None:
            final.append((number, place, evaluation))
    final.sort(key=lambda one: one[0])  # what an earlier final asked for, too, is older
    kept = [*search, *((place, evaluation) for _, place, evaluation in final)]
    gone = {one.key for _, one in placed} - {one.key for _, one in kept}
    return kept, tuple(one for one in measured if one.key not in gone)


def _groups(
    task: Task, records: Sequence[Record], finished: dict[str, Any]
) -> dict[str, TrainedDesign]:
    """Return the groups of the final by role; none while the run goes on, or if one is broken."""
    by_key = {record.evaluation.key: record.evaluation for record in records}
    found = {}
    for role in ROLES:
        keys = finished.get(role)
        group = [by_key.get(str(key)) for key in keys] if isinstance(keys, list) else []
        known = [evaluation for evaluation in group if evaluation is not None]
        if not known or len(known) < len(group):
            return {}
        found[role] = trained_design(role, task, known)
    return found


def _passed_over(
    task: Task, records: Sequence[Record], manifest: Manifest, finished: dict[str, Any]
) -> tuple[str, ...]:
    """Return which designs of the final failed their audit, and why, in words."""
    by_key = {record.evaluation.key: record for record in records}
    told = finished.get("passed_over", [])
    said = []
    for one in told if isinstance(told, list) else []:
        keys = one.get("keys") if isinstance(one, dict) else None
        keys = keys if isinstance(keys, list) else []
        group = [by_key[str(key)] for key in keys if str(key) in by_key]
        worths = [r.evaluation.score(manifest.settings.objective) for r in group]
        scores = [score for score in worths if score is not None]
        if scores:
            worth = in_unit(fmean(scores), manifest.settings.objective, task.goal.unit)
            said.append(f"{group[0].place.changed} ({worth}). {one.get('reason', '')}")
    return tuple(said)


def _role(groups: dict[str, TrainedDesign]) -> str:
    """Return which group the champion is; of groups that share their evaluations the first."""
    keys = {name: [e.key for e in group.evaluations] for name, group in groups.items()}
    return next((name for name in ROLES[1:] if name in keys and keys[name] == keys["champion"]), "")


def _changes(then: dict[str, str], now: dict[str, str]) -> tuple[str, ...]:
    return tuple(sorted(part for part in then | now if then.get(part) != now.get(part)))
