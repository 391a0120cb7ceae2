"""A run folder read back: champion, human design, the way there, what to keep in mind."""

from __future__ import annotations

import json
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from fake_run import NASTY, PROVENANCE, FakeRun, finished_run
from robomore.designers.recorded import ATTEMPTS
from robomore.errors import RunFolderError
from robomore.report import Summary, as_data, summarise, write_report
from robomore.store import Ledger
from robomore.store.ledger import Proposal
from robomore.types import Design, Place, Slot, Status


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Summary:
    path = tmp_path_factory.mktemp("finished")
    finished_run(path)
    return summarise(path)


def test_a_finished_run_has_a_champion_measured_over_its_seeds(finished: Summary) -> None:
    assert finished.final
    assert finished.champion is not None
    assert finished.champion.fitness is not None
    assert finished.champion.fitness.values == (12.0, 13.0, 14.0)
    assert finished.champion.parameters["front_radius"] == pytest.approx(0.03)
    assert finished.human is not None
    assert finished.human.volume == pytest.approx(0.106814, abs=1e-6)


def test_the_ratio_compares_efficiencies(finished: Summary) -> None:
    assert finished.champion and finished.human and finished.ratio
    assert finished.ratio.mean == pytest.approx(
        (13.0 / finished.champion.volume) / (21.0 / finished.human.volume)
    )


def test_every_evaluation_is_counted_once_by_status(finished: Summary) -> None:
    assert finished.counts == {Status.OK: 20, Status.REWARD_FAILED: 1, Status.TIMED_OUT: 1}
    assert finished.cost.evaluations == 22
    assert finished.cost.steps == 14 * 1_000 + 6 * 4_000
    assert finished.cost.core_seconds == pytest.approx(22 * 2.5)


def test_the_way_leads_from_the_grids_best_over_each_improvement_to_the_final(
    finished: Summary,
) -> None:
    led = [step for step in finished.way if step.leads]
    assert [(s.place.stage, s.changed) for s in led] == [
        ("coarse", "design"),
        ("fine", "morphology"),
        ("final", "training"),
    ]
    assert (led[0].place.morphology, led[0].place.reward) == (3, 2)
    # The reward of cycle 1 was worse, so it is no step; the other branch never improved.
    (other,) = (step for step in finished.way if not step.leads)
    assert (other.place.morphology, other.place.reward) == (3, 1)


def test_a_champion_that_only_shrank_is_called_that(finished: Summary) -> None:
    assert any("fitness is 13.00 m against 21.00 m" in said for said in finished.cautions)


def test_failures_are_gathered_by_reason(finished: Summary) -> None:
    assert {failure.status for failure in finished.failures} == {
        Status.REWARD_FAILED,
        Status.TIMED_OUT,
    }


def test_the_contract_of_show_json(finished: Summary) -> None:
    data = json.loads(json.dumps(as_data(finished)))
    champion = data["champion"]
    assert champion["parameters"]["back_length"] == 1.0
    assert "def _get_rew" in champion["reward"]
    assert champion["fitness"] == 13.0
    assert champion["efficiency"] == pytest.approx(13.0 / champion["volume"])
    assert champion["spread"]["fitness"]["std"] == pytest.approx(1.0)
    assert len(champion["seeds"]) == 3
    assert data["evaluations"] == {"ok": 20, "reward-failed": 1, "timed-out": 1}
    assert data["provenance"] == PROVENANCE
    assert data["final"] is True


def test_an_unfinished_run_has_a_best_so_far_and_no_ratio(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    run.coarse()
    run.fine()
    summary = summarise(tmp_path)
    assert not summary.final
    assert summary.champion is not None
    assert summary.champion.name == "best so far"
    assert summary.champion.fitness is not None
    assert summary.champion.fitness.values == (14.0,)
    assert summary.human is None
    assert summary.ratio is None
    assert "not finished" in summary.cautions[0]
    assert as_data(summary)["final"] is False


def test_a_run_that_has_just_begun(tmp_path: Path) -> None:
    FakeRun(tmp_path)
    with pytest.raises(RunFolderError, match="same command"):
        summarise(tmp_path)


def test_a_run_of_failures_alone_has_no_champion(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    run.add(design, Place(stage="coarse"), None, Status.CRASHED, "gone")
    summary = summarise(tmp_path)
    assert summary.champion is None
    assert as_data(summary)["champion"] is None
    assert summary.cautions == ("Nothing has been trained successfully yet.",)


def test_few_seeds_and_luck_are_named(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    run.coarse()
    run.final(run.fine(), fitness=(2.0, 3.0))
    said = " ".join(summarise(tmp_path).cautions)
    assert "Only 2 training seeds" in said
    assert "partly luck" in said


def test_a_resumed_run_is_read_in_the_order_of_the_search(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    best = run.fine()
    run.coarse()
    run.final(best)
    assert [place.stage for place, _ in summarise(tmp_path).placed] == (
        ["coarse"] * 12 + ["fine"] * 4 + ["final"] * 6
    )


def test_a_folder_that_is_no_run(tmp_path: Path) -> None:
    with pytest.raises(RunFolderError, match="robomore run"):
        summarise(tmp_path)


def test_a_branch_of_which_nothing_was_measured_has_its_start_on_the_way(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    run.coarse()
    place = Place(stage="fine", cycle=1, branch=1, changed="reward")
    run.add(Design(run.morphology(0.5), run.reward(9.0)), place, 1.0)
    steps = summarise(tmp_path).way
    assert [(s.place.morphology, s.place.reward, s.leads) for s in steps] == [
        (3, 2, True),
        (3, 1, False),
    ]


def test_slots_that_stayed_empty_are_named_wherever_one_looks(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    with closing(Ledger(run.folder.ledger)) as ledger:
        for attempt in range(ATTEMPTS):
            for slot in (Slot("fine", "reward", 1, 2), Slot("coarse", "morphology", 0, 1)):
                ledger.add_proposal(Proposal(replace(slot, attempt=attempt), failure=NASTY), "")
        # Refilled by a fresh proposal, or still being asked for.
        for slot in (Slot("coarse", "reward", 0, 0), Slot("coarse", "reward", 0, 1)):
            ledger.add_proposal(Proposal(slot, failure="no"), "")
    summary = summarise(tmp_path)
    assert [str(one.slot) for one in summary.empty] == [
        "coarse morphology 2",
        "fine reward 2 of branch 2",
    ]
    assert [(p.morphology, p.reward) for p in summary.untried] == [(1, 0), (1, 1), (1, 2)]
    assert "2 slots stayed empty" in " ".join(summary.cautions)
    assert as_data(summary)["empty_slots"][0] == {"slot": "coarse morphology 2", "reason": NASTY}
    run.coarse()
    page = write_report(tmp_path).read_text()
    assert "Slots that stayed empty" in page and "coarse morphology 2" in page
    assert NASTY not in page
