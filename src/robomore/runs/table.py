"""A run as a table: one row an evaluation, in each place where it was asked for."""

from __future__ import annotations

import csv
import hashlib
import importlib
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from robomore.errors import InputError
from robomore.plain_files import cannot_write
from robomore.plan import Plan
from robomore.runs.lineage import Record
from robomore.tasks import Task

Row = dict[str, Any]


def rows(
    records: Sequence[Record], seconds: Mapping[str, float], task: Task, plan: Plan
) -> list[Row]:
    """Return one row an evaluation, in the order of the search.

    Units: fitness as the task says (`Fitness.unit`), volume m³, efficiency that of fitness over
    m³, energy J, lengths as the task says, times core-seconds.

    Args:
        records: of a run.
        seconds: that each took, by the key of its evaluation.
        task: of the run.
        plan: of the run.
    """
    return [_row(one, seconds[one.evaluation.key], task, plan) for one in records]


def _row(record: Record, seconds: float, task: Task, plan: Plan) -> Row:
    place, evaluation = record.place, record.evaluation
    design = evaluation.design
    return {
        "place": plan.describe(place),
        "stage": place.stage,
        # No reader takes this for a number, as it would "5.1" and "5.10", or for a date.
        "index": "|".join(map(str, place.index)),
        "changed": place.changed,
        "repeat": place.repeat,
        "status": str(evaluation.status),
        "fitness": evaluation.fitness,
        "volume": evaluation.volume,
        "efficiency": evaluation.efficiency,
        "energy": evaluation.energy,
        "cost_of_transport": evaluation.cost_of_transport,
        "steps": evaluation.job.steps,
        "core_seconds": seconds,
        "seed": evaluation.job.seed,
        **dict(zip(task.names, design.morphology.parameters, strict=True)),
        "morphology_idea": design.morphology.idea,
        "reward_idea": design.reward.idea,
        "reward_hash": hashlib.sha256(design.reward.source.encode()).hexdigest()[:12],
        "diagnosis": evaluation.diagnosis,
        "key": evaluation.key,
        "parent": place.parent,
    }


def dataframe(found: Sequence[Row]) -> Any:
    """Return rows as a `pandas.DataFrame`.

    Raises:
        InputError: pandas is not installed.
    """
    try:
        pandas = importlib.import_module("pandas")
    except ImportError:
        raise InputError(
            "to_dataframe() needs pandas: pip install 'robomore[table]'; rows() gives the same as "
            "a list of dictionaries, and needs nothing"
        ) from None
    return pandas.DataFrame(found)


def csv_text(found: Sequence[Row]) -> str:
    """Return rows as CSV, with a line of names first."""
    file = io.StringIO(newline="")
    writer = csv.DictWriter(file, list(dict.fromkeys(name for row in found for name in row)))
    writer.writeheader()
    writer.writerows(_plain(row) for row in found)
    return file.getvalue()


def write_csv(found: Sequence[Row], path: Path) -> None:
    """Write rows as CSV in UTF-8.

    Raises:
        InputError: the file cannot be written.
    """
    try:
        path.write_text(csv_text(found), encoding="utf-8", newline="")
    except OSError as error:
        raise cannot_write(path, error, "name another file") from None


def write_parquet(found: Sequence[Row], path: Path) -> None:
    """Write rows as Parquet.

    Raises:
        InputError: pandas or pyarrow is not installed, or the file cannot be written.
    """
    try:
        importlib.import_module("pyarrow")
        frame = importlib.import_module("pandas").DataFrame(found)
    except ImportError as error:
        raise InputError(
            f"Parquet needs {error.name}, which is not installed: pip install 'robomore[table]', "
            "or write --csv"
        ) from None
    try:
        frame.to_parquet(path)
    except OSError as error:
        raise cannot_write(path, error, "name another file") from None


_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def _plain(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row whose texts no spreadsheet takes for a formula."""
    return {
        name: f"'{value}" if isinstance(value, str) and value[:1] in _FORMULA else value
        for name, value in row.items()
    }
