"""Runs the cells of a study, one after the other or side by side, and writes what they show."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing
from dataclasses import replace
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

from robomore.designers import LanguageModel, Replay
from robomore.errors import InputError, Interrupted, NothingTrained, RunFolderError
from robomore.events import Observer, ignore
from robomore.executors import EXECUTORS, Executor, thread_map
from robomore.experiment import run
from robomore.experiment.designing import designer_identity
from robomore.experiment.run import available_cores
from robomore.options import with_options
from robomore.plain_files import PlainFolder
from robomore.runs import Run, load_run
from robomore.search import METHODS, make_method
from robomore.search.robomore.settings import RoboMoReSettings
from robomore.settings import RunSettings, from_options
from robomore.studies.presets import Scale
from robomore.studies.remeasured import Remeasured
from robomore.studies.retraining import GIVEN, retraining
from robomore.studies.study import Arm, Cell, Results, Study
from robomore.tasks import get_task
from robomore.training.settings import versions_for

FORMATS = ("svg", "pdf", "png")


def cells_of(study: Study, tasks: Sequence[str], scale: Scale, seeds: int) -> list[Cell]:
    """Return the cells of a study, seed by seed, so that one that is stopped has whole seeds.

    An arm that changes nothing at this scale is left out: without screening, for example, where
    nothing is screened.

    Args:
        study: what is compared.
        tasks: ids of tasks; those of the study if there are none.
        scale: how large its runs are.
        seeds: runs of each arm on each task.

    Raises:
        InputError: an unknown task, or an option that cannot be used.
    """
    if seeds < 1:
        raise InputError(f"--seeds is {seeds}; give a number from 1 up")
    plain = with_options(scale.settings, **study.change)
    if study.whole_grid:
        plain = replace(plain, evaluations=_pairs(plain))
    budget = replace(scale, settings=plain).budget_steps
    arms: list[tuple[object, Arm]] = []
    for arm in study.arms:
        settings = arm.settings(plain)
        method = settings.method
        options = from_options(METHODS.get(method.name).Settings, method.options, method.name)
        whole = method.name, options, arm.start_from, replace(settings, method=plain.method)
        if all(whole != other for other, _ in arms):
            arms.append((whole, arm))
    found = []
    asked = tasks or study.tasks
    for task in asked:
        _refuse_misfit(study, task)
    for seed in range(seeds):
        searched: dict[str, Cell] = {}
        for task in dict.fromkeys((study.searched, *asked) if study.searched else asked):
            for _, arm in arms:
                settings = arm.settings(plain)
                make_method(settings.method)
                cell = Cell(task, arm, seed, settings, budget, searched.get(arm.name))
                found.append(cell)
                if task == study.searched:
                    searched[arm.name] = cell
    return found


def _pairs(settings: RunSettings) -> int:
    """Return how many pairs the grid of the method `robomore` has."""
    method = settings.method
    options = from_options(RoboMoReSettings, method.options, method.name)
    return options.morphologies * options.rewards


def _refuse_misfit(study: Study, task: str) -> None:
    """Refuse a task in which the designs of a study cannot be trained.

    Raises:
        InputError: naming it, and what could be studied.
    """
    names = get_task(task).names
    given = any(arm.options.get("method") == GIVEN for arm in study.arms)
    if given and task not in study.tasks:
        raise InputError(
            f"the study {study.name} has its own robots, for {', '.join(study.tasks)}; leave "
            f"{task} out"
        )
    if study.searched and names != get_task(study.searched).names:
        raise InputError(
            f"the study {study.name} trains what it finds in {study.searched}, and {task} has "
            f"other parameters; choose tasks of the same robot, such as {', '.join(study.tasks)}"
        )


def run_study(
    study: Study,
    cells: Sequence[Cell],
    out: Path,
    *,
    designer: str | LanguageModel | Replay | None = None,
    executor: str | Executor = "processes",
    workers: int | None = None,
    containment: str | None = None,
    side_by_side: int = 1,
    tell: Callable[[int, Cell], Observer] = lambda index, cell: ignore,
    measuring: Callable[[int, Cell, int], None] = lambda index, cell, count: None,
    ended: Callable[[int, Cell, Run], None] = lambda index, cell, run: None,
) -> Results:
    """Run what is missing of a study; tables and figures are written at the end.

    Args:
        study: what is compared.
        cells: of the study (`cells_of`).
        out: its folder.
        designer: who proposes in the arms whose methods ask one.
        executor: where evaluations run, see `robomore.run`. All cells share it.
        workers: evaluations side by side.
        containment: `strict` or `relaxed`, see `robomore.run`.
        side_by_side: cells that run at the same time. They fill each other's gaps: a search waits
            at the end of each of its batches, and one cell alone keeps only a few workers busy.
            The numbers do not depend on it. The executor must take calls from several threads.
        tell: is called before each cell, and returns who observes its run.
        measuring: is called where policies of a cell are measured again for the curves, with how
            many. Without Matplotlib there are no curves.
        ended: is called after each cell, with its run.

    Raises:
        InputError: something asked for cannot be done.
        RunFolderError: a cell's folder holds another run.
        Interrupted: Ctrl-C; the same call goes on where this one stopped.
    """
    again = Remeasured(out) if study.curves and _pyplot() else None
    with ExitStack() as stack:
        if isinstance(executor, str):
            make = EXECUTORS.get(executor)
            executor = stack.enter_context(closing(make(workers or available_cores())))

        def done(index: int, cell: Cell, executor: Executor) -> tuple[Cell, Run]:
            cell = retraining(cell, searches) if cell.retrains else cell
            folder = out / cell.folder
            observe = tell(index, cell)
            asks = make_method(cell.settings.method).needs_designer
            asked = (designer or "offline") if asks else None
            found = _finished(cell, folder, asked)
            if found is None:
                try:
                    found = run(
                        cell.task,
                        cell.settings,
                        designer=asked,
                        seed=cell.seed,
                        executor=executor,
                        out=folder,
                        budget_steps=cell.budget_steps,
                        containment=containment,
                        observe=observe,
                        name=f"{study.name}-{cell.arm.name}",
                        start_from=cell.arm.start_from,
                    )
                except NothingTrained:
                    # Its ledger tells why; the tables tell how many runs found something.
                    found = load_run(folder)
            if again is not None:
                again.add(found, partial(measuring, index, cell))
            ended(index, cell, found)
            finished.append(index)
            return cell, found

        def all_of(chosen: Callable[[Cell], bool]) -> list[tuple[Cell, Run]]:
            calls = [
                partial(done, index, cell, executor)
                for index, cell in enumerate(cells)
                if chosen(cell)
            ]
            return thread_map(side_by_side)(calls)

        finished: list[int] = []
        searches: list[tuple[Cell, Run]] = []
        try:
            searches = all_of(lambda cell: cell.retrains is None)
            # Where a search found nothing, there is nothing to train elsewhere.
            nothing = [cell.folder for cell, run in searches if not run.found]
            trained = all_of(lambda one: bool(one.retrains and one.retrains.folder not in nothing))
        except (KeyboardInterrupt, Interrupted):
            raise Interrupted(
                f"stopped; {len(finished)} of {len(cells)} runs are done and kept in {out}, and "
                "the same command goes on from there, also with a run that is half done"
            ) from None
    order = {cell.folder: index for index, cell in enumerate(cells)}
    all_done = sorted(searches + trained, key=lambda one: order[one[0].folder])
    own = {cell.folder.name for cell in cells}
    others = [name for name in PlainFolder(out).names("cells") if name not in own]
    results = Results(tuple(all_done), again.scores if again else {}, tuple(others))
    write_results(study, results, out)
    return results


def write_results(study: Study, results: Results, out: Path) -> list[Path]:
    """Write the tables of a study, and its figures if Matplotlib is installed; return the files.

    Figures of an earlier call that are not drawn anew are removed: they are of other runs.

    Raises:
        InputError: a file cannot be written.
        NotPlainError: a link or the like has its name.
    """
    folder, written = PlainFolder(out), []
    try:
        for name, content in (*_tables(study, results), *_drawn(study, results)):
            folder.make(name.partition("/")[0])
            folder.write(name, content)
            written.append(out / name)
        _remove_figures(folder, {file.name for file in written})
    except OSError as error:
        raise InputError(f"cannot write to {out} ({error.strerror}); name another --out") from None
    return written


def _tables(study: Study, results: Results) -> Iterator[tuple[str, bytes]]:
    for table in study.told(results):
        yield f"tables/{table.name}.md", table.markdown().encode()
        yield f"tables/{table.name}.tex", table.latex().encode()
        yield f"tables/{table.name}.csv", table.csv().encode()


def _drawn(study: Study, results: Results) -> Iterator[tuple[str, bytes]]:
    pyplot = _pyplot()
    if pyplot is None:
        return
    for name, draw in study.figures(results).items():
        figure, axes = pyplot.subplots(figsize=(8.6, 4.8), layout="constrained")
        draw(axes)
        for ending in FORMATS:
            drawn = BytesIO()
            figure.savefig(drawn, format=ending)
            yield f"figures/{name}.{ending}", drawn.getvalue()
        pyplot.close(figure)


def _remove_figures(folder: PlainFolder, drawn: set[str]) -> None:
    """Remove the figures that were drawn before, each of them in all formats, and are not now."""
    there = set(folder.names("figures"))
    for name in sorted({name.rpartition(".")[0] for name in there}):
        files = [f"{name}.{ending}" for ending in FORMATS]
        if there.issuperset(files) and not drawn.issuperset(files):
            for file in files:
                folder.remove(f"figures/{file}")


def _pyplot() -> Any:
    """Return the module that draws, or `None` where Matplotlib is not installed."""
    from robomore.visualize.canvas import matplotlib

    try:
        return matplotlib("pyplot")
    except InputError:
        return None


def _finished(
    cell: Cell, folder: Path, designer: str | LanguageModel | Replay | None
) -> Run | None:
    """Return the run of a cell that is done; what is not, or is another run, is left to `run`."""
    try:
        found = load_run(folder)
    except RunFolderError:
        return None
    manifest, settings = found.manifest, cell.settings
    known = (
        manifest.task,
        manifest.seed,
        manifest.settings,
        tuple(start.origin for start in manifest.starts),
        (manifest.designer, manifest.designer_settings),
        manifest.versions,
    )
    wanted = (
        cell.task,
        cell.seed,
        settings,
        cell.arm.start_from,
        designer_identity(designer),
        versions_for(settings.trainer),
    )
    return found if known == wanted and found.final and not found.task_changes else None
