"""`show` and `report`: a run looked back at, any of its evaluations too."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cli.commands import Command
from fake_run import (
    PROVENANCE,
    FakeRun,
    economy_run,
    finished_run,
    foreign_run,
    random_run,
    reference_run,
)
from robomore.runs import load_run
from robomore.runs.words import number, with_interval
from robomore.types import Design, Place, Reward


def test_show_prints_the_champion_and_who_proposed_it(robomore_: Command, finished: Path) -> None:
    said = robomore_("show", finished)
    assert said.status == 0
    assert "preset quick; method robomore, designer offline, seed 7, finished" in said.out
    assert PROVENANCE in said.out
    run = load_run(finished)
    assert run.headline is not None and run.headline.interval is not None
    assert with_interval(run.headline, digits=3) in said.out
    assert "±" not in said.out
    assert "fine: branch 1, cycle 1, new morphology" in said.out
    assert "def _get_rew" in said.out


def test_show_prints_which_half_made_the_difference(robomore_: Command, finished: Path) -> None:
    said = robomore_("show", finished)
    assert "found morphology" in said.out and "reference reward" in said.out
    run = load_run(finished)
    assert run.pairs is not None
    assert said.words.count(run.pairs.verdict) == 1


def test_show_json_is_json_alone(robomore_: Command, finished: Path) -> None:
    said = robomore_("show", finished, "--json")
    assert said.err == ""
    assert said.json["champion"]["fitness"]["mean"] == 13.0
    assert said.json["provenance"] == PROVENANCE


@pytest.mark.parametrize(
    "more", ["".join(f"    x = {n}\n" for n in range(20_000)), f"    x = '{'y' * 200_000}'\n"]
)
def test_of_a_foreign_reward_of_any_length_only_the_beginning_is_printed(
    robomore_: Command, tmp_path: Path, more: str
) -> None:
    run = FakeRun(tmp_path / "run")
    reward = Reward(run.reference.reward.source.rstrip() + "\n" + more, "long")
    run.add(Design(run.reference.morphology, reward), Place(stage="coarse", index=(0, 0)), 12.0)
    said = robomore_("show", tmp_path / "run")
    assert said.status == 0 and "def _get_rew" in said.out
    assert len(said.out) < 30_000 and said.out.count("\n") < 300
    left = len(reward.source.rstrip())
    assert f"more characters of {left:,}; the same command with --json has all of it" in said.out
    assert robomore_("show", tmp_path / "run", "--json").json["champion"]["reward"] == reward.source


def test_show_of_a_run_that_goes_on(robomore_: Command, tmp_path: Path) -> None:
    FakeRun(tmp_path / "run").coarse()
    said = robomore_("show", tmp_path / "run")
    assert "not finished" in said.out
    assert "best so far" in said.out


@pytest.mark.parametrize("make", [random_run, reference_run, foreign_run])
def test_show_and_report_know_no_method(robomore_: Command, tmp_path: Path, make: object) -> None:
    make(tmp_path / "run")  # type: ignore[operator]
    assert robomore_("show", tmp_path / "run").status == 0
    assert robomore_("report", tmp_path / "run").status == 0


def test_show_takes_any_evaluation_by_the_beginning_of_its_key(
    robomore_: Command, finished: Path
) -> None:
    said = robomore_("show", finished, "--evaluation", "key001")
    assert said.status == 0
    assert "reference" in said.out
    failed = robomore_("show", finished, "--evaluation", "key008")
    assert failed.status == 0 and "reward-failed" in failed.out
    other = robomore_("show", finished, "--reference")
    assert other.status == 0 and "def _get_rew" in other.out


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--evaluation", "key"), "evaluations begin with 'key'"),
        (("--evaluation", "nope"), "no evaluation has the key 'nope'"),
        (("--evaluation", "key001", "--reference"), "not both"),
    ],
)
def test_an_evaluation_that_is_not_there_is_named(
    robomore_: Command, finished: Path, options: tuple[str, ...], expected: str
) -> None:
    for command in ("show", "report", "play"):
        said = robomore_(command, finished, *options)
        assert said.status == 2 and expected in said.err and said.err.count("\n") == 1


def test_the_reference_comes_with_the_final(robomore_: Command, tmp_path: Path) -> None:
    FakeRun(tmp_path / "run").coarse()
    said = robomore_("show", tmp_path / "run", "--reference")
    assert said.status == 2 and "has no final yet" in said.err


def test_a_reference_that_never_trained_is_told(robomore_: Command, tmp_path: Path) -> None:
    run = finished_run(tmp_path / "run")
    reference = load_run(run.path).reference
    assert reference is not None
    for one in reference.evaluations:
        run.fail(one)
    for command in (("show",), ("report",), ("export", "--to", tmp_path / "out"), ("play",)):
        said = robomore_(*command, run.path, "--reference")
        assert said.status == 2 and "no training of the reference design succeeded" in said.err
    shown = robomore_("show", run.path)
    assert [
        line.split()[-2:] for line in shown.out.splitlines() if line.startswith("training seeds")
    ] == [["5", "0"]]


def test_report_writes_where_it_is_told(robomore_: Command, finished: Path, tmp_path: Path) -> None:
    assert robomore_("report", finished).out.strip() == str(finished / "report.html")
    assert (finished / "report.html").stat().st_size > 10_000
    assert robomore_("report", finished, "--out", tmp_path / "page.html").status == 0
    assert (tmp_path / "page.html").is_file()


def test_show_begins_with_the_objective(robomore_: Command, tmp_path: Path) -> None:
    economy_run(tmp_path)
    run = load_run(tmp_path)
    said = robomore_("show", tmp_path).out
    score = run.champion.score(run.objective) if run.champion else None
    assert score is not None
    (row,) = [line for line in said.splitlines() if line.startswith("transport economy")]
    assert number(score.mean) in row
    assert re.search(r"how the search got there +transport economy +efficiency m/m³", said)


def test_replays_are_of_one_run(robomore_: Command, finished: Path, tmp_path: Path) -> None:
    said = robomore_("report", finished, finished, "--replays", "3", "--out", tmp_path / "a.html")
    assert said.status == 2 and "--replays are of one run" in said.err
