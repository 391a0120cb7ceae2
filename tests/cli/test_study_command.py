"""`study`: lists, plans, refuses, and ends with its tables."""

from __future__ import annotations

from pathlib import Path

import untrained  # noqa: F401  # makes its executor known
from cli.commands import Command
from robomore.studies import STUDIES


def test_without_a_name_all_studies_are_listed(robomore_: Command) -> None:
    said = robomore_("study")
    assert said.status == 0
    assert "[bold]" not in said.out
    assert all(name in said.out and STUDIES.get(name).summary in said.out for name in STUDIES)


def test_a_plan_starts_nothing(robomore_: Command, tmp_path: Path) -> None:
    words = ("study", "ablation", "hopper", "--preset", "quick", "--seeds", "2", "--plan")
    said = robomore_(*words, "--out", str(tmp_path / "study"))
    assert said.status == 0
    assert "hopper-without-reward-s1" in said.out
    assert "16 runs, at most 4,760,000 control steps: 2,840,000 of search and" in said.out
    assert not (tmp_path / "study").exists()
    assert said.err == "left out, the same as another arm at this preset: without-screening\n"


def test_a_plan_costs_what_the_documents_say(robomore_: Command) -> None:
    """Of designs that are only trained, nothing is searched."""
    said = robomore_("study", "motivation", "--preset", "quick", "--plan")
    assert "12 runs, at most 1,680,000 control steps: 240,000 of search and 1,440,000" in said.out


def test_one_arm_runs_and_its_table_is_told(robomore_: Command, tmp_path: Path) -> None:
    words = ("study", "comparison", "swimmer", "--preset", "smoke", "--seeds", "1")
    words = (*words, "--arm", "reference", "--executor", "untrained", "--out", str(tmp_path))
    said = robomore_(*words)
    assert said.status == 0, said.err
    assert "run 1 of 1: swimmer-reference-s0" in said.err
    assert "m/m³, the reference design" in said.err
    assert "| swimmer | reference |" in said.out
    assert (tmp_path / "tables" / "found.tex").is_file()
    assert "covers only" not in said.out
    said = robomore_(*words[:-5], "slim-reference", *words[-4:])
    assert said.status == 0, said.err
    assert "This table covers only what its call named: slim-reference on swimmer." in said.out


def test_what_cannot_be_used_is_refused(robomore_: Command) -> None:
    for words, told in (
        (("comparsion",), "Did you mean 'comparison'"),
        (("comparison", "--arm", "cma"), "has no arm 'cma'"),
        (("comparison", "--preset", "fast"), "no preset is called 'fast'"),
        (("comparison", "--seeds", "0"), "--seeds is 0"),
    ):
        said = robomore_("study", *words)
        assert said.status == 2 and told in said.err, words
