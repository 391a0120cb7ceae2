"""A run as a table: units, order, and files that a spreadsheet or a script can read."""

from __future__ import annotations

import csv
import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from fake_run import FakeRun, finished_run
from robomore.errors import InputError
from robomore.runs import load_run
from robomore.runs.table import dataframe, write_csv, write_parquet
from robomore.types import Design, Morphology, Place


@pytest.fixture
def rows(tmp_path: Path) -> list[dict[str, Any]]:
    finished_run(tmp_path)
    return load_run(tmp_path).rows()


def without(*names: str) -> Any:
    """Return an `import_module` for a machine without these packages."""
    load = importlib.import_module

    def fail(name: str) -> ModuleType:
        if name in names:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return load(name)

    return fail


def test_a_row_is_an_evaluation_in_si_units(rows: list[dict[str, Any]]) -> None:
    assert len(rows) == 36
    first = rows[0]
    assert (first["place"], first["stage"], first["index"]) == (
        "coarse: morphology 1, reward 1",
        "coarse",
        "0|0",
    )
    assert first["fitness"] == 10.0
    assert first["efficiency"] == pytest.approx(first["fitness"] / first["volume"])
    assert first["front_radius"] == pytest.approx(0.1)
    assert first["steps"] == 1_000
    assert first["core_seconds"] == 2.5
    assert [row["stage"] for row in rows] == ["coarse"] * 12 + ["fine"] * 4 + ["final"] * 20
    failed = rows[7]
    assert failed["status"] == "reward-failed"
    assert failed["fitness"] is failed["efficiency"] is None
    by_key = {row["key"]: row for row in rows}
    improved = next(row for row in rows if row["stage"] == "fine" and row["changed"])
    assert by_key[improved["parent"]]["place"] == "coarse: morphology 4, reward 3"


def test_one_reward_has_one_hash(rows: list[dict[str, Any]]) -> None:
    coarse = rows[:12]
    assert len({row["reward_hash"] for row in coarse}) == 3
    assert coarse[0]["reward_hash"] == coarse[3]["reward_hash"]


def test_csv_holds_every_column_and_row(rows: list[dict[str, Any]], tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    write_csv(rows, path)
    with path.open(newline="", encoding="utf-8") as file:
        read = list(csv.DictReader(file))
    assert len(read) == len(rows)
    assert list(read[0]) == list(rows[0])
    assert float(read[0]["efficiency"]) == rows[0]["efficiency"]
    assert read[7]["fitness"] == ""


@pytest.mark.parametrize("text", ["=HYPERLINK(1)", "+1+1", "-1+1", "@SUM(A1)"])
def test_no_spreadsheet_takes_a_text_for_a_formula(tmp_path: Path, text: str) -> None:
    run = FakeRun(tmp_path / "run")
    design = Design(Morphology(run.task.reference, text), run.reward(1.0))
    run.add(design, Place(stage="coarse", index=(0, 0)), -1.0)
    write_csv(load_run(run.path).rows(), tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(newline="", encoding="utf-8") as file:
        (row,) = csv.DictReader(file)
    assert row["morphology_idea"] == f"'{text}"
    # A negative number is a number.
    assert float(row["fitness"]) == -1.0


def test_a_reader_merges_no_places(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    run = FakeRun(tmp_path / "run")
    for column in (1, 10):
        design = Design(run.morphology(0.5), run.reward(float(column)))
        run.add(design, Place(stage="coarse", index=(5, column)), 1.0)
    write_csv(load_run(run.path).rows(), tmp_path / "run.csv")
    assert list(pandas.read_csv(tmp_path / "run.csv")["index"]) == ["5|1", "5|10"]


def test_a_table_that_cannot_be_written(rows: list[dict[str, Any]], tmp_path: Path) -> None:
    with pytest.raises(InputError, match="name another file"):
        write_csv(rows, tmp_path / "nowhere" / "run.csv")


@pytest.mark.parametrize("missing", ["pandas", "pyarrow"])
def test_parquet_says_what_it_needs(
    rows: list[dict[str, Any]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, missing: str
) -> None:
    # Neither may be installed here: whichever is asked for first is named.
    names = ("pandas", "pyarrow") if missing == "pyarrow" else ("pandas",)
    monkeypatch.setattr(importlib, "import_module", without(*names))
    with pytest.raises(InputError, match=r"Parquet needs (pandas|pyarrow).*robomore\[table\]"):
        write_parquet(rows, tmp_path / "run.parquet")


def test_without_pandas_a_data_frame_says_what_to_do(
    rows: list[dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(importlib, "import_module", without("pandas"))
    with pytest.raises(InputError, match=r"robomore\[table\].*rows\(\)"):
        dataframe(rows)


def test_with_pandas_a_table_is_a_data_frame(rows: list[dict[str, Any]]) -> None:
    pandas = pytest.importorskip("pandas")
    frame = dataframe(rows)
    assert isinstance(frame, pandas.DataFrame)
    assert list(frame.columns) == list(rows[0])
