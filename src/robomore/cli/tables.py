"""`robomore compare`: runs side by side, and rows as files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from robomore.cli.output import console, write, write_json
from robomore.errors import InputError

if TYPE_CHECKING:
    from robomore.runs import Run
    from robomore.runs.table import Row


def compare(
    *runs: Path,
    csv: Annotated[Path | None, Parameter(allow_leading_hyphen=True)] = None,
    as_json: Annotated[bool, Parameter("--json", negative="")] = False,
) -> None:
    """Put runs side by side: what each found, over its own reference, and what it cost.

    Parameters
    ----------
    runs
        Folders of runs. A run may still go on.
    csv
        Write the table as CSV into this file; `-` for the terminal.
    as_json
        Print the table as JSON: one object for each run.
    """
    from robomore.runs import compare as side_by_side

    if not runs:
        raise InputError("which runs? name their folders: robomore compare RUN RUN")
    comparison = side_by_side(runs)
    if as_json:
        write_json(comparison.rows())
    elif csv is not None:
        write_rows(comparison.rows(), csv)
    else:
        _print(comparison.runs)


def write_rows(rows: list[Row], path: Path) -> None:
    """Write rows as CSV into a file, or to the terminal for `-`."""
    from robomore.runs.table import csv_text, write_csv

    if path == Path("-"):
        write(csv_text(rows).replace("\r\n", "\n"))
        return
    write_csv(rows, path)
    write(f"{path}: {len(rows)} rows\n")


def _print(runs: tuple[Run, ...]) -> None:
    from rich.table import Table

    from robomore.runs.words import duration, in_unit, with_interval

    screen = console()
    table = Table(box=None, pad_edge=False)
    for heading in ("run", "task", "method", "seed"):
        table.add_column(heading)
    for heading in ("champion", "found", "found over the reference", "search steps", "core time"):
        table.add_column(heading, justify="right")
    for run in runs:
        manifest, champion = run.manifest, run.champion
        score = champion.score(run.objective) if champion else None
        found = run.found.score(run.objective) if run.found else None
        ratio = with_interval(run.found_ratio, digits=3) if run.found_ratio else "-"
        table.add_row(
            run.folder.name,
            manifest.task,
            manifest.settings.method.name,
            str(manifest.seed),
            in_unit(score.mean, run.objective, run.fitness_unit) if score else "-",
            in_unit(found.mean, run.objective, run.fitness_unit) if found else "-",
            ratio if run.final else "not finished",
            f"{run.search_steps:,}",
            duration(run.cost.core_seconds),
        )
    screen.print(table)
    asked = _asked(runs)
    for said, names in asked.items():
        screen.print(f"{'each run' if len(asked) == 1 else ', '.join(names)}: {said}")
    if len(asked) > 1:
        screen.print(
            "These runs were not asked for the same: compare only those of one line.",
            style="yellow",
        )


def _asked(runs: tuple[Run, ...]) -> dict[str, list[str]]:
    """Return names of runs by what their numbers hang on: objective, steps and final."""
    found: dict[str, list[str]] = {}
    for run in runs:
        settings = run.manifest.settings
        seeds, final = settings.final.seeds, f"{settings.final.steps:,} steps"
        said = (
            f"{run.objective}, trainings of {settings.candidate.steps:,} steps; final of {seeds} "
            f"seed{'s' if seeds != 1 else ''}, {final}"
        )
        found.setdefault(said, []).append(run.folder.name)
    return found
