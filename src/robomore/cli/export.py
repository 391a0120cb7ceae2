"""`robomore compare` and `robomore export`: runs as tables, for people and for other programs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from robomore.cli.output import console, write_json
from robomore.errors import InputError

if TYPE_CHECKING:
    from robomore.runs import Run
    from robomore.runs.table import Row

_STDOUT = Path("-")


def compare(
    *runs: Path,
    csv: Path | None = None,
    as_json: Annotated[bool, Parameter("--json", negative="")] = False,
) -> None:
    """Show several runs side by side: one row for each run.

    Parameters
    ----------
    runs
        Folders of runs. A run may still go on.
    csv
        Write the table into this file as CSV, or to standard output with `-`.
    as_json
        Print the table as JSON.
    """
    from robomore.runs import compare as side_by_side

    if not runs:
        raise InputError("which runs? name the folders of one or more runs")
    found = side_by_side(runs)
    if as_json:
        write_json(found.rows())
    elif csv is not None:
        _write_csv(found.rows(), csv)
    else:
        _print(found.runs)


def export(run: Path, /, *, csv: Path | None = None, parquet: Path | None = None) -> None:
    """Write all evaluations of a run as a table: one row for each evaluation.

    Parameters
    ----------
    run
        A run's folder. The run may still go on.
    csv
        Write CSV into this file, or to standard output with `-`.
    parquet
        Write Parquet into this file. This needs pandas and pyarrow.
    """
    from robomore.runs import load_run
    from robomore.runs.table import write_parquet

    if (csv is None) == (parquet is None):
        raise InputError("where to? give either --csv FILE or --parquet FILE")
    rows = load_run(run).rows()
    if parquet is not None:
        write_parquet(rows, parquet)
        sys.stdout.write(f"{parquet}\n")
    elif csv is not None:
        _write_csv(rows, csv)


def _write_csv(rows: list[Row], path: Path) -> None:
    from robomore.runs.table import csv_text, write_csv

    if path == _STDOUT:
        sys.stdout.write(csv_text(rows))
    else:
        write_csv(rows, path)
        sys.stdout.write(f"{path}\n")


def _print(runs: tuple[Run, ...]) -> None:
    from rich.table import Table

    from robomore.runs.words import duration, number, unit_of, with_interval

    table = Table(box=None, pad_edge=False)
    for heading, side in (
        ("task", "left"),
        ("method", "left"),
        ("seed", "right"),
        ("champion", "right"),
        ("times the reference", "right"),
        ("search steps", "right"),
        ("core time", "right"),
        ("run", "left"),
    ):
        table.add_column(heading, justify="right" if side == "right" else "left")
    for run in runs:
        manifest = run.manifest
        score = run.champion.score(run.objective) if run.champion else None
        ratio = with_interval(run.ratio, digits=3) if run.ratio else "-"
        table.add_row(
            manifest.task,
            manifest.settings.method.name,
            str(manifest.seed),
            f"{number(score.mean)} {unit_of(run.objective)}" if score else "-",
            ratio if run.final else "not finished",
            f"{run.search_steps:,}",
            duration(run.cost.core_seconds),
            str(run.folder),
        )
    console().print(table)
