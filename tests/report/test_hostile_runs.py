"""Runs that somebody else wrote, with right digests and wrong numbers: refused or shown."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from fake_run import FakeRun, finished_run
from robomore.errors import LedgerDamaged, RunFolderError
from robomore.plan import Plan
from robomore.rendering.drawing import draw
from robomore.rendering.pictures import frame_around, image
from robomore.report.page import render
from robomore.report.sharing import share_image
from robomore.report.svg import axes, axis_around
from robomore.runs import load_run
from robomore.store.rows import digest
from robomore.tasks import get_task
from robomore.types import Morphology


def forged(folder: Path, change: Callable[[dict[str, Any]], None], table: str, column: str) -> None:
    """Change the JSON of every row as somebody would who can compute a digest."""
    with closing(sqlite3.connect(folder / "ledger.sqlite")) as db, db:
        names = [name for _, name, *_ in db.execute(f"PRAGMA table_info({table})")]
        for number, *row in db.execute(f"SELECT rowid, * FROM {table}").fetchall():
            at = names.index(column)
            body = json.loads(row[at])
            change(body)
            text = json.dumps(body)
            row[at] = text.encode() if isinstance(row[at], bytes) else text
            query = f"UPDATE {table} SET {column} = ?, digest = ? WHERE rowid = ?"
            db.execute(query, (row[at], digest(row[:-1]), number))


def sized(number: float) -> Callable[[dict[str, Any]], None]:
    def change(evaluation: dict[str, Any]) -> None:
        if evaluation["status"] == "ok":
            evaluation["efficiency"] = evaluation["fitness"] = number

    return change


@pytest.mark.parametrize("number", [5e-324, -5e-324, 1e-99, -0.0, 1e-13])
def test_numbers_of_no_size_are_shown(tmp_path: Path, number: float) -> None:
    finished_run(tmp_path)
    forged(tmp_path, sized(number), "evaluations", "body")
    run = load_run(tmp_path)
    assert {e.efficiency for e in run.evaluations if e.ok} == {
        0.0 if abs(number) < 1e-100 else number
    }
    assert "<svg" in render(run, 0)


@pytest.mark.parametrize(
    "values", [(5e-324, 1e12), (0.0, 5e-324), (5e-324, 5e-324), (-1e-320, 1e-320), (1e-99, 1.0)]
)
@pytest.mark.parametrize("log", [True, False])
def test_every_axis_has_ticks(values: tuple[float, float], log: bool) -> None:
    axis = axis_around(values, 0.0, 100.0, log)
    assert all(0 <= axis.at(value) <= 100 for value in values)
    assert "<text" in axes(axis, axis, "x", "y")


@pytest.mark.parametrize("number", [1e308, -1e308, 2**63])
@pytest.mark.parametrize("status", ["ok", "reward-failed"])
def test_a_parameter_that_no_robot_has_is_damage(
    tmp_path: Path, number: float, status: str
) -> None:
    def change(evaluation: dict[str, Any]) -> None:
        if evaluation["status"] == status:
            evaluation["job"]["design"]["morphology"]["parameters"][0] = number

    finished_run(tmp_path)
    forged(tmp_path, change, "evaluations", "body")
    with pytest.raises(LedgerDamaged, match="not from -1e12 to 1e\\+12; no robot has that"):
        load_run(tmp_path)


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -2e12, 10**400])
def test_no_morphology_has_such_a_parameter(number: float) -> None:
    with pytest.raises(ValueError, match="no robot has that"):
        Morphology((0.1, number))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"shape": (2,) * 6}, "has 2 axes and 6 sizes of them"),
        ({"shape": (4,)}, "has 2 axes and 1 sizes of them"),
        ({"shape": (-4, -3)}, "has a size below 0"),
        ({"shape": (2**63, 2)}, "more than 1,000,000 places"),
    ],
)
def test_a_plan_whose_shape_is_none_is_refused(
    tmp_path: Path, changes: dict[str, Any], said: str
) -> None:
    run = FakeRun(tmp_path)
    first, *others = run.manifest.plan.stages
    plan = Plan((replace(first, **changes), *others))
    replace(run.manifest, plan=plan).save(run.folder.manifest)
    with pytest.raises(RunFolderError, match=said):
        load_run(tmp_path)


def test_a_plan_that_does_not_fit_its_places_is_refused(tmp_path: Path) -> None:
    run = finished_run(tmp_path)
    plan = Plan(
        tuple(
            replace(stage, axes=("morphology",) * 3, shape=(2, 2, 2)) if stage.is_grid else stage
            for stage in run.manifest.plan.stages
        )
    )
    replace(run.manifest, plan=plan).save(run.folder.manifest)
    with pytest.raises(RunFolderError, match=r"2 numbers in the stage 'coarse', whose axes are"):
        load_run(tmp_path)


@pytest.mark.parametrize("index", [[-1, 0], [2**63, 0], [10**6, 0]])
def test_a_place_that_none_has_is_damage(tmp_path: Path, index: list[int]) -> None:
    run = FakeRun(tmp_path)
    best = run.coarse()

    def change(place: dict[str, Any]) -> None:
        if place["index"] == [0, 0]:
            place["index"] = index

    forged(tmp_path, change, "places", "place")
    assert best.ok
    with pytest.raises(LedgerDamaged, match=r"a number that none has|cannot be read"):
        load_run(tmp_path)


def test_a_title_without_end_is_cut_where_it_is_drawn() -> None:
    task = get_task("swimmer")
    scene = draw(task, task.reference)
    title = "x" * 2**20
    assert image(scene, frame_around(scene, 320, 180), title).size == (320, 180)
    assert share_image({"champion": scene}, title).startswith("data:image/png")
