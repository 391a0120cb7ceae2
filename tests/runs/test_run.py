"""A run folder read back: champion, reference, lineage, counts, and what is refused."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from fake_run import SETTINGS, FakeRun, finished_run, foreign_run, random_run, reference_run
from robomore.errors import InputError, RunFolderError
from robomore.runs import Run, compare, load_run
from robomore.runs.lineage import Record, ancestry
from robomore.settings import FinalSettings
from robomore.store import Ledger, Manifest
from robomore.types import Design, Place, Status


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Run:
    path = tmp_path_factory.mktemp("finished")
    finished_run(path)
    return load_run(path)


def test_a_finished_run_has_a_champion_measured_over_its_seeds(finished: Run) -> None:
    assert finished.final
    assert finished.champion is not None
    assert finished.champion_role == "found"
    assert finished.champion.fitness is not None
    assert finished.champion.fitness.values == (12.0, 12.5, 13.0, 13.5, 14.0)
    assert finished.champion.parameters["front_radius"] == pytest.approx(0.03)
    assert finished.reference is not None
    assert finished.reference.volume == pytest.approx(0.106814, abs=1e-6)
    assert finished.morphology_only and finished.reward_only and finished.found
    assert finished.morphology_only.parameters == finished.found.parameters
    assert finished.morphology_only.design.reward.source == finished.task.reward
    assert finished.reward_only.parameters == finished.reference.parameters
    assert finished.reward_only.design.reward == finished.found.design.reward


def test_behaviour_is_the_mean_over_the_seeds(finished: Run) -> None:
    assert finished.champion is not None
    assert finished.champion.behaviour["forward_distance_m"] == pytest.approx(13.0)
    assert finished.champion.behaviour["forward_speed_m_s"] == pytest.approx(1.3)


def test_the_ratio_compares_what_the_search_compared(finished: Run) -> None:
    assert finished.champion and finished.reference and finished.ratio and finished.fitness_ratio
    assert finished.ratio.mean == pytest.approx(
        (13.0 / finished.champion.volume) / (21.0 / finished.reference.volume)
    )
    assert finished.fitness_ratio.mean == pytest.approx(13.0 / 21.0)
    assert finished.ratio == finished.efficiency_ratio
    assert finished.ratio.interval is not None


@pytest.mark.parametrize(("seeds", "shown"), [(1, False), (2, False), (3, True), (5, True)])
def test_a_headline_takes_three_seeds(tmp_path: Path, seeds: int, shown: bool) -> None:
    settings = replace(SETTINGS, final=FinalSettings(steps=4_000, episodes=4, seeds=seeds))
    run = FakeRun(tmp_path, settings=settings)
    values = (20.0, 21.0, 22.0, 23.0, 24.0)[:seeds]
    run.final(run.coarse(), values, values, values, values)
    found = load_run(tmp_path)
    assert found.ratio is not None
    assert (found.headline is not None) is shown
    assert (found.ratio.interval is not None) is (seeds == 5)


@pytest.mark.parametrize("side", ["champion", "reference"])
@pytest.mark.parametrize(("failed", "shown"), [(2, True), (3, False)])
def test_seeds_that_failed_carry_no_headline(
    tmp_path: Path, side: str, failed: int, shown: bool
) -> None:
    run = finished_run(tmp_path)
    for one in getattr(load_run(tmp_path), side).evaluations[:failed]:
        run.fail(one)
    found = load_run(tmp_path)
    assert found.ratio is not None
    assert (found.headline is not None) is shown
    (row,) = compare([found]).rows()
    assert row["final_seeds"] == (5 - failed if side == "champion" else 5)


@pytest.mark.parametrize(("worst", "shown"), [(-0.5, False), (0.0, False), (0.01, True)])
def test_a_reference_that_may_be_zero_makes_no_headline(
    tmp_path: Path, worst: float, shown: bool
) -> None:
    run = FakeRun(tmp_path)
    run.final(run.coarse(), reference=(worst, 0.1, 0.6, 0.7, 0.05))
    found = load_run(tmp_path)
    assert found.ratio is not None
    assert (found.headline is not None) is shown


def test_the_smoke_preset_has_no_headline_with_any_number_of_seeds(tmp_path: Path) -> None:
    run = FakeRun(tmp_path, preset="smoke-final-seeds5")
    run.final(run.coarse())
    found = load_run(tmp_path)
    assert found.ratio is not None
    assert found.headline is None


def test_a_champion_that_is_the_reference_has_no_headline(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    run.final(run.coarse(), champion="reference")
    found = load_run(tmp_path)
    assert found.champion_role == "reference"
    assert found.headline is None


@pytest.mark.parametrize("role", ["found", "morphology_only", "reward_only", "reference"])
def test_the_champions_role_is_its_group(tmp_path: Path, role: str) -> None:
    run = FakeRun(tmp_path)
    run.final(run.coarse(), champion=role)
    found = load_run(tmp_path)
    assert found.champion_role == role
    group = getattr(found, role)
    assert found.champion is not None
    assert [e.key for e in found.champion.evaluations] == [e.key for e in group.evaluations]


def test_every_evaluation_is_counted_once_by_status(finished: Run) -> None:
    assert finished.counts == {Status.OK: 34, Status.REWARD_FAILED: 1, Status.TIMED_OUT: 1}
    assert finished.cost.evaluations == 36
    assert finished.cost.steps == 16 * 1_000 + 20 * 4_000
    assert finished.search_steps == 16 * 1_000
    assert finished.cost.core_seconds == pytest.approx(36 * 2.5)


def test_a_design_in_two_places_is_one_evaluation(tmp_path: Path) -> None:
    random_run(tmp_path)
    run = load_run(tmp_path)
    # The best sample has the reference reward, so it is found and morphology_only at once.
    assert len(run.records) == 4 + 4 * 5
    assert run.cost.evaluations == 4 + 2 * 5
    assert run.champion_role == "found"


def test_the_lineage_leads_from_a_first_idea_to_the_searchs_best(finished: Run) -> None:
    assert [finished.plan.describe(record.place) for record in finished.lineage] == [
        "coarse: morphology 4, reward 3",
        "fine: branch 1, cycle 1, new morphology",
    ]


def test_any_method_has_a_lineage_by_the_parents_it_names(tmp_path: Path) -> None:
    foreign_run(tmp_path)
    run = load_run(tmp_path)
    assert [run.plan.describe(record.place) for record in run.lineage] == [
        "matrix: morphology 2, reward 2",
        "evolution: generation 1, member 1",
        "evolution: generation 2, member 1",
    ]


def test_a_ledger_whose_parents_run_in_a_circle_ends(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    first = run.add(design, Place(stage="fine", index=(0, 0), parent="key002"), 1.0)
    second = run.add(design, Place(stage="fine", index=(0, 1), parent="key001"), 2.0)
    itself = run.add(design, Place(stage="fine", index=(0, 2), parent="key003"), 3.0)
    found = load_run(tmp_path)
    assert [record.evaluation.key for record in found.lineage] == [itself.key]
    records = tuple(Record(record.place, record.evaluation) for record in found.records)
    assert [r.evaluation.key for r in ancestry(second.key, records)] == [first.key, second.key]


def test_failures_are_gathered_by_reason(finished: Run) -> None:
    assert {failure.status for failure in finished.failures} == {
        Status.REWARD_FAILED,
        Status.TIMED_OUT,
    }


def test_an_unfinished_run_has_a_best_so_far_and_no_ratio(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    run.fine(run.coarse())
    found = load_run(tmp_path)
    assert not found.final
    assert found.champion is not None
    assert found.champion.name == "best so far"
    assert found.champion.fitness is not None
    assert found.champion.fitness.values == (14.0,)
    assert found.champion_role == ""
    assert found.reference is None
    assert found.ratio is found.headline is found.pairs is None
    assert len(found.lineage) == 2


def test_a_final_that_the_ledger_holds_in_part_is_no_final(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    best = run.coarse()
    with closing(Ledger(run.folder.ledger)) as ledger:
        ledger.add_event("finished", champion=[best.key], found=[best.key], reference=["nowhere"])
    assert not load_run(tmp_path).final


def test_a_run_that_has_just_begun(tmp_path: Path) -> None:
    FakeRun(tmp_path)
    with pytest.raises(RunFolderError, match="same command"):
        load_run(tmp_path)


def test_a_run_of_failures_alone_has_no_champion(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    run.add(design, Place(stage="coarse", index=(0, 0)), None, Status.CRASHED, "gone")
    found = load_run(tmp_path)
    assert found.champion is None
    assert found.lineage == ()
    with pytest.raises(InputError, match="nothing trained yet"):
        found.load_policy()


def test_a_resumed_run_is_read_in_the_order_of_the_search(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    best = run.fine()
    run.coarse()
    run.final(best)
    assert [record.place.stage for record in load_run(tmp_path).records] == (
        ["coarse"] * 12 + ["fine"] * 4 + ["final"] * 20
    )


def test_a_folder_that_is_no_run(tmp_path: Path) -> None:
    with pytest.raises(RunFolderError, match="robomore run"):
        load_run(tmp_path)


def test_an_evaluation_is_found_by_the_beginning_of_its_key(finished: Run) -> None:
    assert finished.evaluation("key001").key == "key001"
    with pytest.raises(InputError, match=r"no evaluation has the key 'nothing'.*robomore export"):
        finished.evaluation("nothing")
    with pytest.raises(InputError, match="9 evaluations begin with 'key00'"):
        finished.evaluation("key00")
    with pytest.raises(InputError, match="no evaluation has the key ''"):
        finished.evaluation("")


def test_a_key_that_begins_another_is_itself(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    run.coarse()
    with closing(Ledger(run.folder.ledger)) as ledger:
        longer = replace(load_run(tmp_path).evaluation("key001"), key="key0011")
        ledger.add_evaluation(longer)
        ledger.add_place(Place(stage="fine", index=(0, 0)), longer.key)
    assert load_run(tmp_path).evaluation("key001").key == "key001"


def test_a_curve_is_read_when_it_is_asked_for(finished: Run) -> None:
    assert finished.evaluation("key001").curve is None
    curve = finished.curve("key001")
    assert curve is not None
    assert curve.steps == (200, 400, 600, 800, 1_000)
    assert curve.series["episode_return"] == (None, 4.0, 6.0, 8.0, 10.0)
    (failed,) = (e for e in finished.evaluations if e.status is Status.TIMED_OUT)
    assert finished.curve(failed.key) is None


def test_a_policy_that_is_gone_says_what_to_do(finished: Run) -> None:
    with pytest.raises(InputError, match=r"has no policy: .*same command"):
        finished.load_policy()


def test_an_edited_task_is_named_by_its_parts(tmp_path: Path) -> None:
    run = finished_run(tmp_path)
    assert load_run(tmp_path).task_changes == ()
    part = sorted(run.manifest.task_parts)[0]
    edited = run.manifest.task_parts | {part: "other", "removed": "part"}
    replace(run.manifest, task_parts=edited).save(run.folder.manifest)
    found = load_run(tmp_path)
    assert found.task_changes == tuple(sorted([part, "removed"]))
    assert f"was edited after this run ({', '.join(found.task_changes)})" in found.warnings[0]


def test_runs_stand_side_by_side_whatever_their_method(tmp_path: Path) -> None:
    for name, write in (("a", finished_run), ("b", random_run), ("c", reference_run)):
        write(tmp_path / name)
    found = compare([load_run(tmp_path / "a"), tmp_path / "b", str(tmp_path / "c")])
    rows = found.rows()
    assert [row["method"] for row in rows] == ["robomore", "random", "reference"]
    assert len({tuple(row) for row in rows}) == 1
    assert rows[0]["ratio"] == pytest.approx(7.4956, rel=1e-4)
    assert rows[0]["ratio_low"] < rows[0]["ratio"] < rows[0]["ratio_high"]
    assert rows[2]["ratio"] == pytest.approx(1.0)
    assert [row["search_steps"] for row in rows] == [16_000, 4_000, 1_000]
    assert msgspec.json.decode(msgspec.json.encode(rows)) == rows


def test_a_method_that_is_not_installed_can_be_looked_at(tmp_path: Path) -> None:
    run = foreign_run(tmp_path)
    assert Manifest.load(run.folder.manifest).settings.method.name == "ours"
    assert load_run(tmp_path).ratio is not None


def test_a_task_with_other_parameters_is_refused(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    best = run.coarse()
    fewer = replace(best.job.design.morphology, parameters=(1.0, 2.0))
    job = replace(best.job, design=replace(best.design, morphology=fewer))
    with closing(Ledger(run.folder.ledger)) as ledger:
        ledger.add_evaluation(replace(best, job=job))
    with pytest.raises(InputError, match="other parameters of the task swimmer"):
        load_run(tmp_path)


def test_a_run_is_printed_in_one_line(trained_run: Path) -> None:
    found = load_run(trained_run)
    assert repr(found) == (
        f"<Run of swimmer in {str(trained_run)!r}: finished, {len(found.evaluations)} evaluations>"
    )
