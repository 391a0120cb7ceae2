"""Grids, the best so far and slots that stayed empty, for any method."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from fake_run import NASTY, SETTINGS, FakeRun, finished_run, foreign_run, random_run
from robomore.designers.recorded import ATTEMPTS
from robomore.errors import RunFolderError
from robomore.events import Cut
from robomore.plan import Plan, Stage
from robomore.report.page_data import page_data
from robomore.runs import load_run
from robomore.runs.cost import Cost
from robomore.runs.empty import EmptySlot, lines_without
from robomore.runs.grid import grids
from robomore.runs.progress import progress
from robomore.store import Ledger
from robomore.store.schema import Proposal
from robomore.types import Design, MethodSettings, Place, Slot, Status


def test_a_grid_has_every_cell_and_knows_the_reference_reward(tmp_path: Path) -> None:
    finished_run(tmp_path)
    (grid,) = grids(load_run(tmp_path))
    assert grid.shape == (4, 3)
    assert set(grid.cells) == {(i, j) for i in range(4) for j in range(3)}
    assert grid.reference_rewards == {0}
    best = grid.cells[3, 2].evaluation
    assert best is not None
    assert best.fitness == 15.0
    failed = grid.cells[2, 1].evaluation
    assert failed is not None
    assert failed.status is Status.REWARD_FAILED


def test_grids_are_found_by_their_axes_not_by_their_name(tmp_path: Path) -> None:
    foreign_run(tmp_path / "foreign")
    random_run(tmp_path / "random")
    assert [grid.stage.name for grid in grids(load_run(tmp_path / "foreign"))] == ["matrix"]
    assert grids(load_run(tmp_path / "random")) == ()


def test_a_grid_that_no_page_can_show_is_refused(tmp_path: Path) -> None:
    stage = Stage(name="matrix", axes=("morphology", "reward"), shape=(1000, 990), evaluations=4)
    run = FakeRun(tmp_path, plan=Plan((stage,)), preset="custom")
    run.add(run.reference, Place(stage="matrix", index=(0, 0)), 10.0)
    with pytest.raises(RunFolderError, match="1000 x 990 pairs"):
        grids(load_run(tmp_path))


def test_cells_say_why_they_were_cut_or_left_out(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    run.add(design, Place(stage="coarse", index=(0, 0)), 3.0, steps=200)
    run.add(design, Place(stage="coarse", index=(0, 1)), 4.0)
    left_out = Place(stage="coarse", index=(1, 1))
    with closing(Ledger(run.folder.ledger)) as ledger:
        ledger.noting(lambda event: None)(Cut(left_out, 0, "its morphology is number 4 of 4"))
        for attempt in range(ATTEMPTS):
            for slot in (Slot("coarse", "reward", (1,)), Slot("coarse", "morphology", (2,))):
                ledger.add_proposal(Proposal(replace(slot, attempt=attempt), failure="no"), "")
    (grid,) = grids(load_run(tmp_path))
    assert grid.cells[0, 0].cut
    assert not grid.cells[0, 1].cut
    assert grid.cells[1, 1].reason == "not tried: its morphology is number 4 of 4"
    assert grid.cells[2, 0].reason == "no morphology was proposed: no"
    # The reference reward is column 0, so the second proposed reward is column 2.
    assert grid.cells[0, 2].reason == "no reward was proposed: no"
    assert grid.cells[3, 0].reason == ""


def test_lines_that_nobody_proposes_shift_the_others(tmp_path: Path) -> None:
    empty = [EmptySlot(Slot("coarse", "reward", (0,)), "no")]
    for reference_reward, column in (("in", 1), ("out", 0)):
        options = {**SETTINGS.method.options, "reference_reward": reference_reward}
        settings = replace(SETTINGS, method=MethodSettings("robomore", options))
        stage = FakeRun(tmp_path / reference_reward, settings=settings).manifest.plan.stages[0]
        assert lines_without(empty, "reward", stage) == {column: "no reward was proposed: no"}
        assert lines_without(empty, "morphology", stage) == {}
        assert lines_without(empty, "reward", replace(stage, name="other")) == {}


def test_the_best_so_far_rises_over_the_steps_that_were_spent(tmp_path: Path) -> None:
    finished_run(tmp_path)
    run = load_run(tmp_path)
    points = progress(run)
    assert [point.steps for point in points[:3]] == [1_000, 2_000, 3_000]
    # A failed training is no point, and costs what it was asked for.
    assert len(points) == 11 + 3
    best = [point.best for point in points]
    assert best == sorted(best)
    assert max(point.score for point in points) == best[-1]
    # The very last training failed.
    assert points[-1].steps == run.search_steps - 1_000


def test_a_training_that_goes_on_is_paid_once(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    first = run.add(design, Place(stage="screening", index=(0,)), 3.0, steps=200)
    whole = replace(
        first,
        key="whole",
        job=replace(first.job, steps=1_000),
        steps=1_000,
    )
    with closing(Ledger(run.folder.ledger)) as ledger:
        ledger.add_place(Place(stage="coarse", index=(0, 0)), whole.key)
        ledger.add_evaluation(whole)
    found = load_run(tmp_path)
    assert [point.steps for point in progress(found)] == [1_000]
    assert found.search_steps == 1_000
    # Each stop has seconds of its own.
    assert found.cost.core_seconds == 5.0
    assert [row["core_seconds"] for row in found.rows()] == [5.0, 2.5]
    # What screening looked at is no candidate.
    assert [record.evaluation.key for record in found.searched] == ["whole"]


def test_the_time_of_earlier_rungs_is_told(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    place = Place(stage="coarse", index=(0, 0))
    first = run.add(Design(run.morphology(0.5), run.reward(1.0)), place, 3.0, steps=200)
    whole = replace(first, key="whole", job=replace(first.job, steps=1_000), seconds=4.0)
    with closing(Ledger(run.folder.ledger)) as ledger:
        ledger.add_place(place, whole.key)
        ledger.add_evaluation(whole)
    found = load_run(tmp_path)
    assert found.cost == Cost(evaluations=1, steps=1_000, core_seconds=first.seconds + 4.0)
    (row,) = found.rows()
    assert (row["key"], row["core_seconds"]) == ("whole", first.seconds + 4.0)
    assert page_data(found, (), ())["evaluations"][0]["seconds"] == first.seconds + 4.0


def test_what_is_screened_counts_before_anything_is_trained_to_the_end(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    for number, steps in enumerate((200, 1_000, 400, 1_000)):
        design = Design(run.morphology(0.1 * (number + 1)), run.reward(1.0))
        run.add(design, Place(stage="coarse", index=(number, 0)), 3.0 + number, steps=steps)
    # 4 x 200 to the first rung, 3 x 200 to the second, and 600 for each that goes on.
    assert [point.steps for point in progress(load_run(tmp_path))] == [2_000, 2_600]


def test_branches_advance_side_by_side(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    for branch in (0, 1):
        for cycle in (0, 1):
            design = Design(run.morphology(0.1 + branch / 2 + cycle / 4), run.reward(1.0))
            place = Place(stage="fine", index=(branch, cycle), changed="morphology")
            run.add(design, place, 1.0)
    order = [point.record.place.index for point in progress(load_run(tmp_path))]
    assert order == [(0, 0), (1, 0), (0, 1), (1, 1)]


def test_a_design_with_a_second_seed_stands_by_their_mean(tmp_path: Path) -> None:
    """As the search takes it: the highest single number would be its luckier seed."""
    run = FakeRun(tmp_path)
    lucky, other = (Design(run.morphology(0.5), run.reward(weight)) for weight in (1.0, 2.0))
    place = Place(stage="fine", index=(0, 0), changed="reward")
    first = run.add(lucky, place, 10.0)
    second = run.add(lucky, replace(place, repeat=999_999), 4.0)
    run.add(other, replace(place, index=(0, 1)), 8.0)
    run.add(other, replace(place, index=(0, 1), repeat=999_999), None, Status.UNSTABLE)
    assert first.volume is not None
    best = [point.best * first.volume for point in progress(load_run(tmp_path))]
    assert best == pytest.approx([10.0, 7.0, 8.0])
    leaders = [[e.key for e in point.leader] for point in progress(load_run(tmp_path))]
    assert leaders[:2] == [[first.key], [first.key, second.key]]


def test_slots_that_stayed_empty_are_named_in_the_order_of_the_search(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    with closing(Ledger(run.folder.ledger)) as ledger:
        for attempt in range(ATTEMPTS):
            for slot in (
                Slot("fine", "reward", (1, 0), improves=True),
                Slot("coarse", "morphology", (1,)),
            ):
                ledger.add_proposal(Proposal(replace(slot, attempt=attempt), failure=NASTY), "")
        # Refilled by a fresh proposal, or still being asked for.
        for index in (0, 1):
            ledger.add_proposal(Proposal(Slot("coarse", "reward", (index,)), failure="no"), "")
    found = load_run(tmp_path)
    assert [str(one.slot) for one in found.empty] == ["coarse morphology 2", "fine reward 2.1"]
    assert "2 slots stayed empty" in " ".join(found.warnings)
