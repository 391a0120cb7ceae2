"""`robomore show` and `robomore report`: a run looked back at, from its folder alone."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from robomore.cli.output import console, write_json

if TYPE_CHECKING:
    from rich.console import Console

    from robomore.report.metrics import Spread
    from robomore.report.summary import Summary


def show(
    run: Path, /, *, as_json: Annotated[bool, Parameter("--json", negative="")] = False
) -> None:
    """Show a run: champion and human design, counts, cost, the way there.

    Parameters
    ----------
    run
        A run's folder. The run may still go on.
    as_json
        Print JSON: everything with every digit, per seed too.
    """
    from robomore.report.json_export import as_data
    from robomore.report.summary import summarise

    summary = summarise(run)
    if as_json:
        write_json(as_data(summary))
        return
    screen = console()
    _print_head(screen, summary)
    _print_designs(screen, summary)
    _print_way(screen, summary)
    _print_reward(screen, summary)
    _print_cautions(screen, summary)


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


def print_outcome(summary: Summary) -> None:
    """Print what a run ended with, where the report is, and how to go on."""
    screen = console()
    screen.print()
    _print_head(screen, summary)
    _print_designs(screen, summary)
    _print_cautions(screen, summary)
    sys.stdout.write(
        f"\nreport:   {summary.folder / 'report.html'}\n"
        f"watch:    robomore play {summary.folder}\n"
        f"details:  robomore show {summary.folder}\n"
    )


def _print_head(screen: Console, summary: Summary) -> None:
    from robomore.report.words import EFFICIENCY_UNIT, number

    manifest = summary.manifest
    state = "finished" if summary.final else "not finished"
    screen.print(
        f"{summary.task.title}: {manifest.preset}, designer {manifest.designer}, "
        f"seed {manifest.seed}, {state}",
        style="bold",
        markup=False,
    )
    screen.print(manifest.provenance, markup=False)
    champion, ratio = summary.champion, summary.ratio
    if champion is None or champion.efficiency is None:
        screen.print("nothing has been trained yet")
    elif ratio is None:
        screen.print(f"{champion.name}: {number(champion.efficiency.mean)} {EFFICIENCY_UNIT}")
    else:
        spread = f" (± {number(ratio.std, 2)})" if ratio.std is not None else ""
        screen.print(
            f"{champion.name}: {number(ratio.mean, 3)}{spread} times the human design's "
            f"{summary.objective}",
            style="bold green" if ratio.mean > 1 else "bold",
        )
    screen.print()


def _print_designs(screen: Console, summary: Summary) -> None:
    from rich.table import Table

    from robomore.report.words import EFFICIENCY_UNIT, duration, number

    shown = [one for one in (summary.champion, summary.human) if one]
    table = Table(box=None, pad_edge=False)
    table.add_column("")
    for one in shown:
        table.add_column(one.name, justify="right")
    table.add_row(f"efficiency {EFFICIENCY_UNIT}", *(_cell(one.efficiency) for one in shown))
    table.add_row("fitness m", *(_cell(one.fitness) for one in shown))
    table.add_row("volume m³", *(number(one.volume) for one in shown))
    table.add_row("density kg/m³", *(number(one.body.get("density")) for one in shown))
    table.add_row("training seeds", *(str(len(one.evaluations)) for one in shown))
    for parameter in summary.task.parameters:
        values = (number(one.parameters[parameter.name]) for one in shown)
        table.add_row(f"{parameter.name} {parameter.unit}", *values)
    if shown:
        screen.print(table)
    counts = ", ".join(f"{count} {status}" for status, count in summary.counts.items())
    cost = summary.cost
    screen.print(
        f"\n{cost.evaluations} evaluations ({counts or 'none yet'}): {cost.steps:,} control steps, "
        f"{duration(cost.core_seconds)} of one core"
    )
    spending = summary.spending
    if spending.requests:
        dollars = "of unknown price" if spending.unpriced else f"${spending.cost:.2f}"
        screen.print(
            f"language model: {spending.requests} requests, {spending.tokens:,} tokens, {dollars}"
        )


def _print_way(screen: Console, summary: Summary) -> None:
    from rich.table import Table

    from robomore.report.words import EFFICIENCY_UNIT, number, place_name

    table = Table(box=None, pad_edge=False)
    table.add_column("the way there")
    for heading in (f"efficiency {EFFICIENCY_UNIT}", "fitness m", "volume m³"):
        table.add_column(heading, justify="right")
    for step in summary.way:
        if step.leads:
            table.add_row(
                place_name(step.place) if step.changed != "training" else "final: retrained",
                _cell(step.efficiency),
                _cell(step.fitness),
                number(step.evaluation.volume),
            )
    if table.row_count:
        screen.print()
        screen.print(table)


def _print_reward(screen: Console, summary: Summary) -> None:
    if summary.champion is None:
        return
    reward = summary.champion.design.reward
    screen.print(f"\nreward: {reward.idea}".rstrip(": "), markup=False)
    screen.print(reward.source.rstrip(), markup=False)


def _print_cautions(screen: Console, summary: Summary) -> None:
    if summary.cautions:
        screen.print("\nkeep in mind")
    for caution in summary.cautions:
        screen.print(f"- {caution}", style="yellow", markup=False)


def _cell(measured: Spread | None) -> str:
    from robomore.report.words import number

    if measured is None:
        return "-"
    spread = f" ± {number(measured.std, 2)}" if measured.std is not None else ""
    return number(measured.mean) + spread
