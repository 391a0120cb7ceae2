"""What scripts rely on: the keys of `robomore show --json`, in plain data."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from fake_run import (
    PROVENANCE,
    FakeRun,
    economy,
    economy_run,
    finished_run,
    foreign_run,
    random_run,
    reference_run,
)
from robomore.report import as_data
from robomore.runs import load_run
from robomore.types import Design, Place, Status


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    path = tmp_path_factory.mktemp("json")
    finished_run(path)
    found: dict[str, Any] = json.loads(json.dumps(as_data(load_run(path)), allow_nan=False))
    return found


def test_what_was_asked_for(data: dict[str, Any]) -> None:
    assert (data["task"], data["preset"], data["designer"], data["seed"]) == (
        "swimmer",
        "quick",
        "offline",
        7,
    )
    assert data["method"]["name"] == "robomore"
    assert data["method"]["options"]["morphologies"] == 4
    assert data["objective"] == "efficiency"
    assert data["provenance"] == PROVENANCE
    assert [(stage["name"], stage["role"]) for stage in data["plan"]] == [
        ("coarse", "search"),
        ("fine", "search"),
        ("final", "final"),
    ]
    assert data["plan"][0]["axes"] == ["morphology", "reward"]
    assert data["plan"][0]["shape"] == [4, 3]


def test_the_champion_with_everything_that_was_measured(data: dict[str, Any]) -> None:
    champion = data["champion"]
    assert champion["parameters"]["back_length"] == 1.0
    assert "def _get_rew" in champion["reward"]
    assert champion["fitness"]["mean"] == 13.0
    assert champion["fitness"]["values"] == [12.0, 12.5, 13.0, 13.5, 14.0]
    low, high = champion["fitness"]["interval"]
    assert 12.0 < low < 13.0 < high < 14.0
    assert champion["efficiency"]["mean"] == pytest.approx(13.0 / champion["volume"])
    assert len({one["seed"] for one in champion["evaluations"]}) == 5
    assert (champion["steps"], champion["episodes"]) == (4_000, 4)
    assert champion["behaviour"]["forward_speed_m_s"] == pytest.approx(1.3)


def test_the_pairs_of_the_final(data: dict[str, Any]) -> None:
    assert data["final"] is True
    assert data["champion_role"] == "found"
    assert data["verdict"].startswith("Both made a difference")
    found, reference = data["found"], data["reference"]
    assert found == data["champion"]
    assert data["morphology_only"]["parameters"] == found["parameters"]
    assert data["morphology_only"]["reward"] == reference["reward"]
    assert data["reward_only"]["parameters"] == reference["parameters"]
    assert data["reward_only"]["reward"] == found["reward"]
    ratio = data["ratio"]["efficiency"]
    assert ratio["mean"] == pytest.approx(
        found["efficiency"]["mean"] / reference["efficiency"]["mean"]
    )
    assert ratio["interval"][0] < ratio["mean"] < ratio["interval"][1]


def test_counts_cost_and_lineage(data: dict[str, Any]) -> None:
    assert data["evaluations"] == {"ok": 34, "reward-failed": 1, "timed-out": 1}
    assert data["cost"]["steps"] == 96_000
    assert data["cost"]["search_steps"] == 16_000
    first, second = data["lineage"]
    assert first["place"] == "coarse: morphology 4, reward 3"
    assert second["parent"] == first["key"]
    assert second["changed"] == "morphology"
    assert {failure["status"] for failure in data["failures"]} == {"reward-failed", "timed-out"}


def test_the_objective_is_told_whatever_it_is(data: dict[str, Any], tmp_path: Path) -> None:
    assert data["champion"]["score"] == data["champion"]["efficiency"]
    assert data["ratio"]["objective"] == data["ratio"]["efficiency"]
    economy_run(tmp_path)
    told = as_data(load_run(tmp_path))
    found, reference = told["found"], told["reference"]
    scores = [one["score"] for one in found["evaluations"]]
    assert found["score"]["values"] == scores and found["score"]["interval"]
    assert found["score"]["mean"] != found["efficiency"]["mean"]
    assert told["ratio"]["objective"]["mean"] == pytest.approx(
        found["score"]["mean"] / reference["score"]["mean"]
    )
    assert [step["score"] for step in told["lineage"]] == pytest.approx(
        [economy(step["fitness"], step["volume"]) for step in told["lineage"]]
    )


def test_another_evaluation_is_told_from_the_champion(data: dict[str, Any], tmp_path: Path) -> None:
    assert data["evaluation"] == ""
    finished_run(tmp_path)
    run = load_run(tmp_path)
    key = run.searched[0].evaluation.key
    told = as_data(run.focused(key))
    assert (told["final"], told["evaluation"], told["champion_role"]) == (True, key, "")
    assert told["champion"]["evaluations"][0]["key"] == key


def keys(value: Any) -> Any:
    """Return all names in nested data."""
    if isinstance(value, dict):
        return set(value).union(*(keys(one) for one in value.values()))
    return set().union(*(keys(one) for one in value)) if isinstance(value, list) else set()


def test_names_of_former_versions_are_gone(data: dict[str, Any]) -> None:
    assert not keys(data) & {"std", "human", "way", "cautions", "contestants"}


def test_every_method_has_the_same_keys(data: dict[str, Any], tmp_path: Path) -> None:
    for write in (random_run, reference_run, foreign_run):
        path = tmp_path / write.__name__
        write(path)
        other = as_data(load_run(path))
        assert list(other) == list(data)
        assert list(other["champion"]) == list(data["champion"])


def test_a_run_that_goes_on_has_no_final(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    run.add(design, Place(stage="coarse", index=(0, 0)), None, Status.CRASHED, "gone")
    data = as_data(load_run(tmp_path))
    assert data["final"] is False
    assert data["champion"] is data["reference"] is None
    assert data["ratio"] == {"objective": None, "efficiency": None, "fitness": None}
    assert data["verdict"] == data["champion_role"] == ""


def test_every_key_is_documented(data: dict[str, Any]) -> None:
    docs = (Path(__file__).parents[2] / "docs" / "runs.md").read_text(encoding="utf-8")
    part = docs[docs.index("### JSON of a run") : docs.index("## Reading the files")]
    named = set(data) | set(data["champion"]) | keys(data["lineage"]) | keys(data["plan"])
    named |= keys(data["ratio"]) | keys(data["failures"]) | set(data["cost"])
    assert named
    assert not {name for name in named if f"`{name}`" not in part}
