"""`tasks` and `inspect`: what there is to do, and one robot, untrained."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cli.commands import Command
from robomore.tasks import TASKS, get_task


def test_tasks_lists_all_eight(robomore_: Command) -> None:
    said = robomore_("tasks")
    assert said.status == 0
    assert all(name in said.out for name in TASKS)
    data = robomore_("tasks", "--json").json
    assert [task["id"] for task in data] == list(TASKS)
    assert len(data[5]["parameters"]) == 24


def test_inspect_gives_the_facts_of_the_reference_robot(robomore_: Command) -> None:
    data = robomore_("inspect", "swimmer", "--json").json
    assert data["volume"] == pytest.approx(0.106814, abs=5e-7)
    assert data["density"] == pytest.approx(1000.0)
    assert data["mass"] == pytest.approx(106.814, abs=1e-3)
    assert "rest_height" in data
    assert "{front_radius}" in data["masked_mjcf"]
    assert "{" not in data["mjcf"]
    assert data["picture"] is None


def test_inspect_takes_parameters_as_a_list_or_by_name(robomore_: Command, tmp_path: Path) -> None:
    values = [1.0, 1.0, 1.0, 0.05, 0.05, 0.05]
    file = tmp_path / "morphology.json"
    found = []
    names = get_task("swimmer").names
    for content in (values, dict(zip(names, values, strict=True)), {"parameters": values}):
        file.write_text(json.dumps(content))
        found.append(robomore_("inspect", "swimmer", "--parameters", file, "--json").json)
    assert found[0] == found[1] == found[2]
    assert found[0]["volume"] == pytest.approx(get_task("swimmer").volume(values))


def test_inspect_draws_and_prints(robomore_: Command, tmp_path: Path) -> None:
    picture = tmp_path / "ant.svg"
    said = robomore_("inspect", "ant", "--picture", picture)
    assert said.status == 0
    assert "0.182176 m³" in said.out
    assert str(picture) in said.out
    assert picture.read_text().startswith("<svg")
    assert "{torso_radius}" in robomore_("inspect", "ant", "--mjcf", "masked").out
