"""`robomore show` and `robomore report`: a run looked back at, from its folder alone."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from robomore.cli.output import beginning, console, write, write_json
from robomore.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from robomore.runs import Run, Spread


def show(
    run: Path,
    /,
    *,
    evaluation: str | None = None,
    reference: Annotated[bool, Parameter(negative="")] = False,
    as_json: Annotated[bool, Parameter("--json", negative="")] = False,
) -> None:
    """Show a run: its champion, the reference design, which half made the difference, and the cost.

    Parameters
    ----------
    run
        A run's folder, where the run may still go on; or a gallery, or one champion in it.
    evaluation
        Key of one of the run's evaluations, or its beginning, instead of the champion.
    reference
        Show the reference design of the run's final instead of the champion.
    as_json
        Print JSON: everything with every digit, each training seed too.
    """
    from robomore.report import as_data
    from robomore.runs.gallery import is_entry
    from robomore.store import RunFolder

    folder = RunFolder(run)
    of_a_run = folder.manifest.is_file() or folder.ledger.is_file()
    if run.is_dir() and not of_a_run and _holds_designs(run):
        from robomore.cli.gallery import show_entry, show_gallery

        if evaluation or reference:
            raise InputError(f"{run} is no run; leave out --evaluation and --reference")
        (show_entry if is_entry(run) else show_gallery)(run, as_json)
        return
    chosen = chosen_run(run, evaluation, reference)
    if as_json:
        write_json(as_data(chosen))
        return
    screen = console()
    _print_head(screen, chosen)
    _print_designs(screen, chosen)
    _print_pairs(screen, chosen)
    _print_audit(screen, chosen)
    _print_lineage(screen, chosen)
    _print_reward(screen, chosen)
    _print_warnings(screen, chosen)


def report(
    *runs: Path,
    evaluation: str | None = None,
    reference: Annotated[bool, Parameter(negative="")] = False,
    out: Path | None = None,
    replays: int | None = None,
) -> None:
    """Write a run's report as one HTML file that needs nothing else; of several, how they compare.

    Parameters
    ----------
    runs
        A run's folder. The run may still go on. Of several runs, or of a study's folder, the page
        compares them.
    evaluation
        Key of one of the run's evaluations, or its beginning, instead of the champion.
    reference
        Write about the reference design of the run's final instead of the champion.
    out
        The file; by default `report.html` in the folder, or `report-KEY.html`. Of several runs
        `comparison.html` here, and of a study in its folder.
    replays
        Designs of one run that are shown in motion at most, 12 by default, champion and reference
        first.
    """
    from robomore.report import write_comparison, write_report
    from robomore.report.replays import MOST

    if replays is not None and replays < 0:
        raise InputError(f"--replays is {replays}; give a number from 0")
    if not runs:
        raise InputError("which run? name its folder: robomore report RUN")
    study = len(runs) == 1 and (runs[0] / "cells").is_dir()
    if len(runs) == 1 and not study:
        shown = MOST if replays is None else replays
        write(f"{write_report(chosen_run(runs[0], evaluation, reference), out, shown)}\n")
        return
    if evaluation or reference or replays is not None:
        raise InputError(
            "--evaluation, --reference and --replays are of one run; leave them out, or name one "
            "folder"
        )
    folder = runs[0] if study else Path()
    write(f"{write_comparison(runs, out or folder / 'comparison.html')}\n")


def print_outcome(run: Run) -> None:
    """Print what a run ended with, where the report is, and how to go on."""
    screen = console()
    screen.print()
    _print_head(screen, run)
    _print_designs(screen, run)
    _print_pairs(screen, run)
    _print_audit(screen, run)
    _print_warnings(screen, run)
    write(
        f"\nreport:   {run.folder / 'report.html'}\n"
        f"watch:    robomore play {quote(str(run.folder))}\n"
        f"details:  robomore show {quote(str(run.folder))}\n"
    )


def _holds_designs(path: Path) -> bool:
    """Return whether a folder is a design's, or holds folders of designs."""
    from robomore.runs.gallery import is_entry

    return is_entry(path) or any(is_entry(one) for one in path.iterdir() if one.is_dir())


def chosen_run(path: Path, evaluation: str | None, reference: bool) -> Run:
    """Return the run with what was asked for in the champion's place.

    Raises:
        InputError: both were asked for, or there is no such evaluation, or nothing of the reference
            design trained.
    """
    from robomore.runs import load_run

    run = load_run(path)
    if evaluation and reference:
        raise InputError("give --evaluation or --reference, not both")
    if evaluation:
        return run.focused(evaluation)
    if reference:
        if run.reference is None:
            raise InputError(f"{path} has no final yet, so no reference design; run it on")
        return run.focused(run.reference.best(run.objective).key)
    return run


def _print_head(screen: Console, run: Run) -> None:
    from robomore.options import settings_words
    from robomore.runs.slimmed import over_slimmed
    from robomore.runs.words import in_unit, with_interval

    manifest = run.manifest
    designer = f", designer {manifest.designer}" if manifest.designer else ""
    said = settings_words(manifest.preset, manifest.settings, run.budget_steps)
    screen.print(
        f"{run.task.title}: {said}; method {manifest.settings.method.name}"
        f"{designer}, seed {manifest.seed}, {'finished' if run.found else 'not finished'}",
        style="bold",
    )
    screen.print(manifest.provenance)
    champion = run.champion
    score = champion.score(run.objective) if champion else None
    if champion is None:
        screen.print("nothing has been trained yet")
    elif score is None:
        first = champion.evaluations[0]
        screen.print(f"{champion.name}: {first.status}. {first.diagnosis}")
    elif run.headline is None:
        screen.print(f"{champion.name}: {in_unit(score.mean, run.objective, run.fitness_unit)}")
    else:
        ratio = with_interval(run.headline, digits=3)
        screen.print(
            f"champion over reference, {run.objective}: {ratio}",
            style="bold green" if run.headline.mean > 1 else "bold",
        )
    if slimmed := over_slimmed(run):
        screen.print(slimmed)
    if run.pairs and run.pairs.champion:
        screen.print(f"The champion is {run.pairs.champion}.")
    screen.print()


def _print_designs(screen: Console, run: Run) -> None:
    from rich.table import Table

    from robomore.runs.words import duration, number

    shown = [one for one in (run.champion, run.reference) if one]
    table = Table(box=None, pad_edge=False)
    table.add_column("")
    for one in shown:
        table.add_column(one.name, justify="right")
    for name, heading in _compared(run).items():
        table.add_row(heading, *(_cell(one.score(name)) for one in shown))
    table.add_row("volume m³", *(number(one.volume) for one in shown))
    table.add_row("mass / volume kg/m³", *(number(one.body.get("density")) for one in shown))
    table.add_row("training seeds", *(str(len(one.trained)) for one in shown))
    for parameter in run.task.parameters:
        values = (number(one.parameters[parameter.name]) for one in shown)
        table.add_row(f"{parameter.name} {parameter.unit}", *values)
    if shown:
        screen.print(table)
    counts = ", ".join(f"{count} {status}" for status, count in run.counts.items())
    cost = run.cost
    screen.print(
        f"\n{cost.evaluations} evaluations ({counts or 'none yet'}): {cost.steps:,} control steps, "
        f"{duration(cost.core_seconds)} of one core"
    )
    spending = run.spending
    if spending.requests:
        dollars = "of unknown price" if spending.unpriced else f"${spending.cost:.2f}"
        screen.print(
            f"language model: {spending.requests} requests, {spending.tokens:,} tokens, {dollars}"
        )


def _print_pairs(screen: Console, run: Run) -> None:
    from rich.table import Table

    from robomore.runs.words import unit_of

    if run.pairs is None:
        return
    table = Table(box=None, pad_edge=False)
    table.add_column(f"final: {run.objective} {unit_of(run.objective, run.fitness_unit)}".rstrip())
    for reward in run.pairs.rewards:
        table.add_column(reward, justify="right")
    for morphology, row in zip(run.pairs.morphologies, run.pairs.cells, strict=True):
        table.add_row(morphology, *(_cell(one.score(run.objective)) for one in row))
    screen.print()
    screen.print(table)
    screen.print(run.pairs.verdict)


def _print_audit(screen: Console, run: Run) -> None:
    from robomore.report.audit_words import in_sum
    from robomore.runs.audits import audit_of

    audit = audit_of(run)
    if audit is not None:
        screen.print(f"\naudit: {in_sum(audit, run.fitness_unit)[0]}")


def _print_lineage(screen: Console, run: Run) -> None:
    from rich.table import Table

    from robomore.runs.words import number

    table = Table(box=None, pad_edge=False)
    table.add_column("how the search got there")
    compared = _compared(run)
    for heading in (*compared.values(), "volume m³"):
        table.add_column(heading, justify="right")
    for record in run.lineage:
        one = record.evaluation
        numbers = [*(one.score(name) for name in compared), one.volume]
        table.add_row(run.plan.describe(record.place), *map(number, numbers))
    if table.row_count:
        screen.print()
        screen.print(table)


def _print_reward(screen: Console, run: Run) -> None:
    if run.champion is None:
        return
    reward = run.champion.design.reward
    screen.print(f"\nreward: {reward.idea}".rstrip(": "))
    screen.print(beginning(reward.source.rstrip(), "the same command with --json"))


def _print_warnings(screen: Console, run: Run) -> None:
    if run.warnings:
        screen.print("\nkeep in mind")
    for warning in run.warnings:
        if run.pairs is None or warning != run.pairs.verdict:
            screen.print(f"- {warning}", style="yellow")


def _compared(run: Run) -> dict[str, str]:
    """Return the headings of what designs are told by, the objective first."""
    from robomore.runs.words import unit_of

    return {
        name: f"{name.replace('-', ' ')} {unit_of(name, run.fitness_unit)}".rstrip()
        for name in (run.objective, "efficiency", "fitness")
    }


def _cell(measured: Spread | None) -> str:
    """Return a mean with its interval, or with its values where they are too few for one."""
    from robomore.runs.words import number

    if measured is None:
        return "-"
    if measured.interval:
        low, high = (number(end, 3) for end in measured.interval)
        return f"{number(measured.mean)} [{low}, {high}]"
    if len(measured.values) == 1:
        return number(measured.mean)
    return f"{number(measured.mean)} ({', '.join(number(value, 3) for value in measured.values)})"
