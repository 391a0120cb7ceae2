"""`robomore show` and `robomore report`: a run looked back at, from its folder alone."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec
from cyclopts import Parameter
from rich.table import Table

from robomore.cli.output import console, write_json

if TYPE_CHECKING:
    from rich.console import Console

    from robomore.runs import Run, Spread, TrainedDesign


def show(
    run: Path,
    /,
    *,
    evaluation: str | None = None,
    reference: Annotated[bool, Parameter(negative="")] = False,
    as_json: Annotated[bool, Parameter("--json", negative="")] = False,
) -> None:
    """Show a run: its champion beside the reference design, and the way there.

    Parameters
    ----------
    run
        A run's folder. The run may still go on.
    evaluation
        Show one evaluation instead: its key, or as many of the key's first characters as no other
        key begins with.
    reference
        Show the reference design of the final instead.
    as_json
        Print JSON: everything with every digit, for each seed.
    """
    from robomore.cli.selection import selected
    from robomore.report import as_data
    from robomore.runs import load_run

    found = load_run(run)
    if evaluation is not None or reference:
        _show_design(found, selected(found, evaluation, reference), as_json)
    elif as_json:
        write_json(as_data(found))
    else:
        screen = console()
        _print_head(screen, found)
        _print_designs(screen, found)
        _print_pairs(screen, found)
        _print_lineage(screen, found)
        if found.champion is not None:
            _print_reward(screen, found.champion)
        _print_warnings(screen, found)


def report(run: Path, /, *, out: Path | None = None) -> None:
    """Write a run's report as one HTML file that needs nothing else.

    Parameters
    ----------
    run
        A run's folder. The run may still go on.
    out
        The file; by default `report.html` in the folder.
    """
    from robomore.report import write_report

    sys.stdout.write(f"{write_report(run, out)}\n")


def print_outcome(run: Run) -> None:
    """Print what a run ended with, where the report is, and what to look at next."""
    screen = console()
    screen.print()
    _print_head(screen, run)
    _print_designs(screen, run)
    _print_warnings(screen, run)
    sys.stdout.write(
        f"\nreport:   {run.folder / 'report.html'}\n"
        f"watch:    robomore play {run.folder}\n"
        f"details:  robomore show {run.folder}\n"
    )


def _show_design(run: Run, shown: TrainedDesign, as_json: bool) -> None:
    """Show one design of a run and what was measured of it."""
    if as_json:
        write_json([msgspec.to_builtins(evaluation) for evaluation in shown.evaluations])
        return
    screen = console()
    keys = {evaluation.key for evaluation in shown.evaluations}
    for record in run.records:
        if record.evaluation.key in keys:
            place = run.plan.describe(record.place)
            screen.print(f"{place}  ({record.evaluation.key})", markup=False)
    for evaluation in shown.evaluations:
        if not evaluation.ok:
            screen.print(f"{evaluation.status}: {evaluation.diagnosis}", markup=False)
    screen.print(_table(run, [shown]))
    _print_reward(screen, shown)


def _print_head(screen: Console, run: Run) -> None:
    from robomore.runs.pairs import LABELS
    from robomore.runs.words import unit_of, with_interval

    manifest = run.manifest
    designer = f"designer {manifest.designer}" if manifest.designer else "no designer"
    screen.print(
        f"{run.task.title}: {manifest.preset}, method {manifest.settings.method.name}, "
        f"{designer}, seed {manifest.seed}, {'finished' if run.final else 'not finished'}",
        style="bold",
        markup=False,
    )
    screen.print(manifest.provenance, markup=False)
    score = run.champion.score(run.objective) if run.champion else None
    if run.champion is None or score is None:
        screen.print("Nothing has been trained yet.\n")
        return
    said = with_interval(score, unit_of(run.objective))
    if run.headline is not None:
        said = with_interval(run.headline, f"times the reference design's {run.objective}", 3)
    good = run.headline is not None and run.headline.mean > 1
    screen.print(f"{run.champion.name}: {said}", style="bold green" if good else "bold")
    if run.champion_role:
        screen.print(f"The champion is the {LABELS[run.champion_role]}.")
    screen.print()


def _print_designs(screen: Console, run: Run) -> None:
    from robomore.runs.words import duration

    if shown := [one for one in (run.champion, run.reference) if one]:
        screen.print(_table(run, shown))
    counts = ", ".join(f"{count} {status}" for status, count in run.counts.items())
    cost, spending = run.cost, run.spending
    screen.print(
        f"\n{cost.evaluations} evaluations ({counts or 'none yet'}): {cost.steps:,} control steps, "
        f"{duration(cost.core_seconds)} of one core"
    )
    if spending.requests:
        dollars = "of unknown price" if spending.unpriced else f"${spending.cost:.2f}"
        screen.print(
            f"language model: {spending.requests} requests, {spending.tokens:,} tokens, {dollars}"
        )


def _table(run: Run, shown: Sequence[TrainedDesign]) -> Table:
    """Return designs side by side: what was measured, then their parameters."""
    from robomore.runs.words import LABELS, number

    table = Table(box=None, pad_edge=False)
    table.add_column("")
    for one in shown:
        table.add_column(one.name, justify="right")
    table.add_row(LABELS["efficiency"], *(_cell(one.efficiency) for one in shown))
    table.add_row(LABELS["fitness"], *(_cell(one.fitness) for one in shown))
    table.add_row(LABELS["volume"], *(number(one.volume) for one in shown))
    table.add_row(LABELS["density"], *(number(one.body.get("density")) for one in shown))
    for parameter in run.task.parameters:
        values = (number(one.parameters[parameter.name]) for one in shown)
        table.add_row(f"{parameter.name} ({parameter.unit})", *values)
    return table


def _print_pairs(screen: Console, run: Run) -> None:
    """Print which half of the champion made the difference."""
    from robomore.runs.words import LABELS

    if run.pairs is None:
        return
    table = Table(box=None, pad_edge=False)
    table.add_column(LABELS[run.objective])
    for reward in run.pairs.rewards:
        table.add_column(reward, justify="right")
    for morphology, cells in zip(run.pairs.morphologies, run.pairs.cells, strict=True):
        table.add_row(morphology, *(_cell(one.score(run.objective)) for one in cells))
    screen.print()
    screen.print(table)
    if not run.pairs.doubt:  # Else it stands among the warnings.
        screen.print(run.pairs.verdict, markup=False)


def _print_lineage(screen: Console, run: Run) -> None:
    from robomore.runs.words import LABELS, number

    table = Table(box=None, pad_edge=False)
    table.add_column("how the search got there")
    for name in ("efficiency", "fitness", "volume"):
        table.add_column(LABELS[name], justify="right")
    for record in run.lineage:
        evaluation = record.evaluation
        table.add_row(
            run.plan.describe(record.place),
            *(number(value) for value in (evaluation.efficiency, evaluation.fitness)),
            number(evaluation.volume),
        )
    if table.row_count:
        screen.print()
        screen.print(table)


def _print_reward(screen: Console, shown: TrainedDesign) -> None:
    reward = shown.design.reward
    screen.print(f"\nreward: {reward.idea}".rstrip(": "), markup=False)
    screen.print(reward.source.rstrip(), markup=False)


def _print_warnings(screen: Console, run: Run) -> None:
    if run.warnings:
        screen.print("\nkeep in mind")
    for warning in run.warnings:
        screen.print(f"- {warning}", style="yellow", markup=False)


def _cell(measured: Spread | None) -> str:
    from robomore.runs.words import with_interval

    return "-" if measured is None else with_interval(measured)
