"""What made the difference: told only where the seeds of the final tell it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from fake_run import SETTINGS, FakeRun, random_run, reference_run
from robomore.runs import load_run
from robomore.runs.pairs import Pairs
from robomore.types import Design, Place

HIGH, MIDDLE, LOW = (
    (30.0, 31.0, 32.0, 33.0, 34.0),
    (20.0, 21.0, 22.0, 23.0, 24.0),
    (10.0, 11.0, 12.0, 13.0, 14.0),
)
SPREAD = (11.0, 16.0, 21.0, 26.0, 31.0)
"""Overlaps with all of them."""

BY_FITNESS = replace(SETTINGS, objective="fitness")


def pairs(
    path: Path,
    groups: dict[str, tuple[float, ...]],
    champion: str = "found",
) -> Pairs:
    run = FakeRun(path, settings=BY_FITNESS)
    design = Design(run.morphology(0.5), run.reward(2.0))
    best = run.add(design, Place(stage="coarse", index=(0, 1)), 30.0)
    run.final(best, **groups, champion=champion)
    found = load_run(path)
    assert found.pairs is not None
    assert (found.pairs.verdict in found.warnings) is found.pairs.doubt
    return found.pairs


@pytest.mark.parametrize(
    ("found", "morphology_only", "reward_only", "reference", "champion", "verdict", "doubt"),
    [
        (HIGH, MIDDLE, MIDDLE, LOW, "found", "Both made a difference", False),
        (HIGH, HIGH, MIDDLE, LOW, "found", "The morphology made the difference", True),
        (HIGH, SPREAD, MIDDLE, LOW, "found", "32.00 against 21.00 m, and their seeds", True),
        (HIGH, MIDDLE, HIGH, LOW, "found", "The reward made the difference", True),
        (HIGH, SPREAD, SPREAD, LOW, "found", "cannot be told which half", True),
        (MIDDLE, LOW, LOW, SPREAD, "found", "No difference can be told between the champ", True),
        (LOW, MIDDLE, LOW, LOW, "morphology_only", "The morphology made the differ", True),
        (LOW, MIDDLE, LOW, SPREAD, "morphology_only", "No difference can be told", True),
        (LOW, LOW, MIDDLE, LOW, "reward_only", "The reward made the difference", True),
        (LOW, LOW, LOW, MIDDLE, "reference", "Nothing that was found beats", True),
    ],
)
def test_the_verdict_follows_from_the_seeds(
    tmp_path: Path,
    found: tuple[float, ...],
    morphology_only: tuple[float, ...],
    reward_only: tuple[float, ...],
    reference: tuple[float, ...],
    champion: str,
    verdict: str,
    doubt: bool,
) -> None:
    table = pairs(
        tmp_path,
        {
            "found": found,
            "morphology_only": morphology_only,
            "reward_only": reward_only,
            "reference": reference,
        },
        champion,
    )
    assert verdict in table.verdict
    assert table.doubt is doubt
    assert table.verdict.replace(".00", "").count(".") == 1


def test_few_seeds_tell_nothing_however_far_apart(tmp_path: Path) -> None:
    groups = {
        "found": HIGH[:4],
        "morphology_only": LOW[:4],
        "reward_only": LOW[:4],
        "reference": LOW[:4],
    }
    table = pairs(tmp_path, groups)
    assert table.verdict.startswith("It cannot be told what made the difference")
    assert table.doubt


def test_the_table_names_its_rows_and_columns(tmp_path: Path) -> None:
    table = pairs(tmp_path, {"found": HIGH})
    assert table.morphologies == ("found morphology", "reference morphology")
    assert table.rewards == ("found reward", "reference reward")
    assert [[cell.name for cell in row] for row in table.cells] == [
        ["found", "morphology_only"],
        ["reward_only", "reference"],
    ]
    assert table.champion == "the found morphology under the found reward"


def test_a_search_over_morphologies_alone_has_one_column(tmp_path: Path) -> None:
    random_run(tmp_path)
    table = load_run(tmp_path).pairs
    assert table is not None
    assert table.rewards == ("reference reward",)
    assert [[cell.name for cell in row] for row in table.cells] == [["found"], ["reference"]]
    assert table.champion == "the found morphology under the reference reward"
    assert (
        table.verdict == "The morphology made the difference: the reward is the reference reward."
    )
    assert not table.doubt


def test_a_search_over_rewards_alone_has_one_row(tmp_path: Path) -> None:
    run = FakeRun(tmp_path, settings=BY_FITNESS)
    design = Design(run.reference.morphology, run.reward(2.0))
    best = run.add(design, Place(stage="coarse", index=(0, 1)), 30.0)
    run.final(best, found=HIGH, reference=LOW)
    table = load_run(tmp_path).pairs
    assert table is not None
    assert table.morphologies == ("reference morphology",)
    assert [[cell.name for cell in row] for row in table.cells] == [["found", "reference"]]
    assert table.verdict.startswith("The reward made the difference")


def test_no_search_has_no_pairs(tmp_path: Path) -> None:
    reference_run(tmp_path)
    run = load_run(tmp_path)
    assert run.pairs is None
    assert run.champion_role == "reference"
