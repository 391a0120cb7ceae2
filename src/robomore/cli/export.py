"""`robomore export`: a run's champion as files for other programs, or its numbers as one table."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Group, Parameter

from robomore.cli.output import console, tell, write
from robomore.cli.show import chosen_run
from robomore.errors import InputError

if TYPE_CHECKING:
    from robomore.export import Exported, Printer

_TABLE = Group("Table", sort_key=2)
_DESIGN = Group("Design", sort_key=1)
_PRINT = Group("3D printing", sort_key=3)


def export(
    run: Path,
    /,
    *,
    to: Annotated[Path | None, Parameter(group=_DESIGN)] = None,
    force: Annotated[bool, Parameter(negative="", group=_DESIGN)] = False,
    evaluation: Annotated[str | None, Parameter(group=_DESIGN)] = None,
    reference: Annotated[bool, Parameter(negative="", group=_DESIGN)] = False,
    video: Annotated[bool, Parameter(group=_DESIGN)] = True,
    csv: Annotated[Path | None, Parameter(allow_leading_hyphen=True, group=_TABLE)] = None,
    parquet: Annotated[Path | None, Parameter(group=_TABLE)] = None,
    scale: Annotated[float, Parameter(group=_PRINT)] = 1.0,
    bed: Annotated[tuple[float, float, float], Parameter(group=_PRINT, negative="")] = (
        256.0,
        256.0,
        256.0,
    ),
    wall: Annotated[float, Parameter(group=_PRINT)] = 1.2,
    gap: Annotated[float, Parameter(group=_PRINT)] = 0.4,
) -> None:
    """Write a run's champion as files for other programs, a table of all its evaluations, or both.

    Parameters
    ----------
    run
        A run's folder. The run may still go on.
    to
        Write the champion into this folder: MJCF, URDF, STL, 3MF, ONNX, a Gymnasium package, a
        video and a model card. This needs `pip install 'robomore[export]'`.
    force
        Replace an earlier export in that folder.
    evaluation
        Key of one of the run's evaluations, or its beginning, instead of the champion.
    reference
        Export the reference design of the run's final instead of the champion.
    video
        Make a video; `--no-video` leaves it out, which saves most of the time.
    csv
        Write every evaluation as CSV into this file; `-` for the terminal.
    parquet
        Write every evaluation as Parquet into this file. This needs
        `pip install 'robomore[table]'`.
    scale
        Size of the printed robot over the size of the simulated one.
    bed
        Longest print along three axes, in mm: `--bed 256 256 256`.
    wall
        Thinnest wall that the printer makes, in mm.
    gap
        Narrowest gap that stays open in a print, in mm.
    """
    if to is None and csv is None and parquet is None:
        raise InputError("give one or more of --to FOLDER, --csv FILE and --parquet FILE")
    if to is None and (force or evaluation or reference):
        raise InputError("--force, --evaluation and --reference go with --to FOLDER")
    _write_tables(run, csv, parquet)
    if to is None:
        return
    from robomore.export import Printer, export_run

    printer = Printer(scale=scale, bed=bed, wall=wall, gap=gap)
    exported = export_run(
        chosen_run(run, evaluation, reference),
        to,
        printer=printer,
        video_seconds=10.0 if video else 0.0,
        force=force,
        tell=lambda words: tell(f"making: {words} …\n"),
    )
    _print(exported, printer)


def _write_tables(run: Path, csv: Path | None, parquet: Path | None) -> None:
    from robomore.cli.tables import write_rows
    from robomore.runs import load_run
    from robomore.runs.table import write_parquet

    if csv is None and parquet is None:
        return
    rows = load_run(run).rows()
    if csv is not None:
        write_rows(rows, csv)
    if parquet is not None:
        write_parquet(rows, parquet)
        write(f"{parquet}: {len(rows)} rows\n")


def _print(exported: Exported, printer: Printer) -> None:
    from rich.table import Table

    from robomore.export.printing import fitting_scale, in_mm
    from robomore.runs.words import in_unit, number

    table = Table(box=None, pad_edge=False)
    for heading in ("piece", "size", "verdict"):
        table.add_column(heading)
    for piece in exported.pieces:
        verdict = "printable" if piece.printable else "; ".join(piece.faults)
        table.add_row(piece.name, in_mm(piece.extent), verdict)
    console().print(table)
    largest = fitting_scale(list(exported.pieces), printer)
    here, before = (
        in_unit(one, "fitness", exported.unit) for one in (exported.fitness, exported.recorded)
    )
    write(
        f"\nEvery piece fits the bed at --scale {number(largest, 3)} or less.\n"
        f"fitness:  {here} by the exported code alone, {before} recorded\n"
        f"files:    {len(exported.files)} in {exported.folder}\n"
        f"read:     {exported.folder / 'README.md'}\n"
    )
