"""`robomore compare` and `robomore export`: runs as tables."""

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
        _write_csv(comparison.rows(), csv)
    else:
        _print(comparison.runs)


def export(
    run: Path,
    /,
    *,
    csv: Annotated[Path | None, Parameter(allow_leading_hyphen=True)] = None,
    parquet: Path | None = None,
) -> None:
    """Write every evaluation of a run as one table.

    Parameters
    ----------
    run
        A run's folder. The run may still go on.
    csv
        Write CSV into this file; `-` for the terminal.
    parquet
        Write Parquet into this file. This needs `pip install 'robomore[table]'`.
    """
    from robomore.runs import load_run
    from robomore.runs.table import write_parquet

    if (csv is None) == (parquet is None):
        raise InputError("give one of --csv FILE and --parquet FILE")
    rows = load_run(run).rows()
    if csv is not None:
        _write_csv(rows, csv)
    elif parquet is not None:
        write_parquet(rows, parquet)
        write(f"{parquet}: {len(rows)} rows\n")


def _write_csv(rows: list[Row], path: Path) -> None:
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
    for heading in ("champion", "over the reference", "search steps", "core time"):
        table.add_column(heading, justify="right")
    for run in runs:
        manifest, champion = run.manifest, run.champion
        score = champion.score(run.objective) if champion else None
        ratio = with_interval(run.ratio, digits=3) if run.ratio else "-"
        table.add_row(
            run.folder.name,
            manifest.task,
            manifest.settings.method.name,
            str(manifest.seed),
            in_unit(score.mean, run.objective, run.fitness_unit) if score else "-",
            ratio if run.final else "not finished",
            f"{run.search_steps:,}",
            duration(run.cost.core_seconds),
        )
    screen.print(table)
