"""`run`: which settings the options stand for, and how a run ends in the terminal."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import robomore.experiment
import untrained  # known as an executor once it is imported
from cli.commands import Command, Said
from robomore.evaluation.request import Request
from robomore.runs import load_run
from robomore.settings import preset
from robomore.types import MethodSettings, TrainerSettings

Asked = Callable[..., dict[str, Any]]


@pytest.fixture
def asked(
    robomore_: Command, tmp_path: Path, finished: Path, monkeypatch: pytest.MonkeyPatch
) -> Asked:
    """Return what `run` asks of the library, for a command line."""
    monkeypatch.chdir(tmp_path)

    def ask(*words: str) -> dict[str, Any]:
        found: dict[str, Any] = {}

        def run(task: Any, settings: Any, **options: Any) -> Any:
            found.update(options, task=task.id, settings=settings)
            return load_run(finished)

        monkeypatch.setattr(robomore.experiment, "run", run)
        found["said"] = robomore_("run", "swimmer", *words, "--quiet")
        assert found["said"].status == 0, found["said"].err
        assert found["said"].err == ""
        return found

    return ask


def test_without_options_it_is_the_preset(asked: Asked) -> None:
    found = asked()
    assert found["settings"] == preset("quick")
    assert (found["task"], found["name"], found["seed"]) == ("swimmer", "quick", 0)
    for name in ("designer", "workers", "out", "budget_steps", "time_limit", "containment"):
        assert found[name] is None, name


def test_options_of_every_group_arrive(asked: Asked) -> None:
    found = asked(
        *("--preset", "smoke", "--method", "random", "--method-option", "samples=3"),
        *("--method-option", "deviation=0.2", "--objective", "fitness"),
        *("--budget-steps", "9000", "--time-limit", "30m"),
        *("--steps", "900", "--trainer", "sac", "--trainer-option", "learning_rate=1e-3"),
        *("--trainer-option", "net_arch=[64,32]"),
        *("--final-steps", "800", "--finalists", "2", "--final-seeds", "4"),
        *("--workers", "3", "--executor", "inline", "--containment", "relaxed"),
        *("--out", "here", "--seed", "5"),
    )
    settings = found["settings"]
    assert settings.method == MethodSettings("random", {"samples": 3, "deviation": 0.2})
    assert settings.objective == "fitness"
    assert settings.candidate.steps == 900
    options = {"learning_rate": 1e-3, "net_arch": [64, 32]}
    assert settings.trainer == TrainerSettings("sac", options)
    final = settings.final
    assert (final.steps, final.finalists, final.seeds) == (800, 2, 4)
    assert (found["budget_steps"], found["time_limit"]) == (9000, 1800.0)
    assert (found["workers"], found["executor"]) == (3, "inline")
    assert (found["containment"], found["out"], found["seed"]) == ("relaxed", Path("here"), 5)
    assert found["name"].startswith("smoke-random-samples3-deviation0.2-sac-")


def test_options_of_a_method_are_json_or_text(asked: Asked) -> None:
    rungs = '[{"budget_fraction":0.5,"keep_fraction":0.5}]'
    found = asked(
        *("--method-option", "screening=halving", "--method-option", f"rungs={rungs}"),
        *("--reference-reward", "out"),
    )
    options = found["settings"].method.options
    assert options["screening"] == "halving"
    assert options["rungs"] == [{"budget_fraction": 0.5, "keep_fraction": 0.5}]
    assert options["reference_reward"] == "out"


@pytest.mark.parametrize(
    ("given", "seconds"),
    [("90s", 90.0), ("30m", 1_800.0), ("2h", 7_200.0), ("0.5 h", 1_800.0)],
)
def test_a_time_limit_is_read(asked: Asked, given: str, seconds: float) -> None:
    assert asked("--time-limit", given)["time_limit"] == seconds


def test_a_run_ends_with_its_outcome_and_what_to_look_at(asked: Asked) -> None:
    said: Said = asked()["said"]
    assert "champion over reference, efficiency" in said.out
    assert "report.html" in said.out and "robomore play" in said.out
    assert "time limit" not in said.out


def test_a_method_without_designer_runs_without_one(robomore_: Command, tmp_path: Path) -> None:
    words = ("run", "swimmer", "--preset", "smoke", "--method", "random")
    said = robomore_(*words, "--executor", "untrained", "--out", tmp_path / "a", "--json")
    assert said.status == 0, said.err
    assert said.json["designer"] == "" and said.json["final"]
    for options in (("--designer", "offline"), ("--model", "openai:any"), ("--by", "slot")):
        said = robomore_(*words, *options, "--out", tmp_path / "b")
        assert said.status == 2 and "asks no designer" in said.err
    assert not (tmp_path / "b").exists()


def test_after_its_time_limit_a_run_ends_well_and_goes_on_later(
    robomore_: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured: list[Request] = []
    made_up = untrained.made_up
    monkeypatch.setattr(untrained, "made_up", lambda it: measured.append(it) or made_up(it))
    # Each evaluation takes a second, and nothing else takes any time.
    clock = SimpleNamespace(monotonic=lambda: float(len(measured)))
    monkeypatch.setattr(sys.modules["robomore.experiment.run"], "time", clock)
    words = ("run", "swimmer", "--preset", "smoke", "--method", "random", "--quiet")
    words = (*words, "--executor", "untrained", "--out", str(tmp_path / "run"))
    said = robomore_(*words, "--time-limit", "2s")
    assert said.status == 0, said.err
    assert len(measured) == 2
    assert "not finished" in said.out and "best so far" in said.out
    assert said.out.endswith("The time limit is over. The same command goes on from here.\n")
    said = robomore_(*words)
    assert said.status == 0 and "time limit" not in said.out
    assert load_run(tmp_path / "run").final
    # What was measured before the limit was not measured again.
    whole = robomore_(*words[:-1], tmp_path / "whole")
    assert whole.status == 0
    mine, theirs = (load_run(tmp_path / name) for name in ("run", "whole"))
    assert [e.key for e in mine.evaluations] == [e.key for e in theirs.evaluations]


def test_a_budget_ends_the_search_and_not_the_final(robomore_: Command, tmp_path: Path) -> None:
    words = ("run", "swimmer", "--preset", "smoke", "--method", "random", "--executor", "untrained")
    said = robomore_(*words, "--budget-steps", "4096", "--out", tmp_path / "run", "--json")
    assert said.status == 0, said.err
    assert said.json["final"] and said.json["cost"]["search_steps"] == 4_096


def test_a_time_limit_in_which_nothing_was_trained_is_no_success(
    finished: Path, robomore_: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    nothing = dataclasses.replace(load_run(finished), champion=None, final=False)
    monkeypatch.setattr(robomore.experiment, "run", lambda *given, **options: nothing)
    said = robomore_("run", "swimmer", "--time-limit", "1s", "--quiet")
    assert said.status == 1 and said.out == ""
    assert "raise --time-limit" in said.err
