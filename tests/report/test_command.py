"""The command in a report gives the run's own settings back."""

from __future__ import annotations

import json
import shlex
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fake_run import FakeRun, finished_run
from robomore.designers.llm.designer import LLMSettings
from robomore.experiment.noting import note_budget
from robomore.experiment.starting import checked_starts
from robomore.options import settings_name, with_options
from robomore.plan import Plan
from robomore.report import as_data
from robomore.report.command import TASK_FILE, command_line
from robomore.report.page import render
from robomore.runs import Run, load_run
from robomore.settings import PRESETS, preset
from robomore.store import Ledger, Manifest
from robomore.types import Morphology, Start

VALUES = st.none() | st.booleans() | st.integers(-9, 9) | st.floats(-1, 1) | st.text("a 1'\"=\\")
CHANGES = st.fixed_dictionaries(
    {},
    optional={
        "method": st.sampled_from(["random", "someones"]),
        "method_options": st.dictionaries(st.sampled_from(["rewards", "x"]), VALUES, min_size=1),
        "trainer": st.sampled_from(["sac", "crossq"]),
        "trainer_options": st.dictionaries(st.just("gamma"), VALUES, min_size=1),
        "steps": st.integers(1, 10**6),
        "final_steps": st.integers(1, 10**6),
        "finalists": st.integers(1, 9),
        "final_seeds": st.integers(1, 9),
        "objective": st.sampled_from(["efficiency", "fitness"]),
    },
)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    path = tmp_path_factory.mktemp("command")
    finished_run(path)
    return load_run(path)


def of(run: Run, manifest: Manifest) -> str | None:
    """Return the command of a run that was asked for by `manifest`."""
    return command_line(replace(run, manifest=manifest))


def manifest(name: str, chosen: dict[str, Any]) -> Manifest:
    settings = with_options(preset(name), **chosen)
    named = settings_name(name, settings)
    return Manifest("ant", {}, named, "offline", "", 3, settings, Plan(()))


def value_of(text: str) -> Any:
    """Return the value of an option as the command line reads it."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def read(command: str) -> tuple[list[str], dict[str, Any]]:
    """Return the words of a command that are no options of settings, and the options."""
    words = shlex.split(command)
    fixed = {"--preset", "--designer", "--seed", "--model"}
    chosen: dict[str, Any] = {}
    rest = words[:3]
    for option, value in zip(words[3::2], words[4::2], strict=True):
        name = option.removeprefix("--").replace("-", "_")
        if option in fixed:
            rest += [option, value]
        elif name.endswith("_option"):
            key, _, text = value.partition("=")
            chosen.setdefault(f"{name}s", {})[key] = value_of(text)
        else:
            chosen[name] = int(value) if value.isdigit() else value
    return rest, chosen


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(name=st.sampled_from(sorted(PRESETS)), chosen=CHANGES)
def test_the_command_gives_the_same_settings(run: Run, name: str, chosen: dict[str, Any]) -> None:
    wanted = manifest(name, chosen)
    command = of(run, wanted)
    assert command is not None
    rest, options = read(command)
    assert rest == [
        *("robomore", "run", "ant"),
        *("--preset", name, "--designer", "offline", "--seed", "3"),
    ]
    settings = with_options(preset(name), **options)
    assert settings == wanted.settings
    # So the folder is the same too.
    assert settings_name(name, settings) == wanted.preset


def test_the_command_names_only_what_differs(run: Run) -> None:
    assert of(run, manifest("quick", {"steps": 5_000, "final_steps": 7_000})) == (
        "robomore run ant --preset quick --designer offline --seed 3 --steps 5000 "
        "--final-steps 7000"
    )


def test_texts_need_no_quotes_but_where_they_read_as_something_else(run: Run) -> None:
    options = {"screening": "halving", "x": "5"}
    command = of(run, manifest("quick", {"method_options": options}))
    assert command is not None
    assert command.endswith("--method-option screening=halving --method-option 'x=\"5\"'")


def test_a_method_without_a_designer_names_none(run: Run) -> None:
    own = replace(manifest("quick", {"method": "random"}), designer="")
    assert of(run, own) == "robomore run ant --preset quick --seed 3 --method random"


def test_settings_that_no_option_reaches_have_no_command(run: Run) -> None:
    own = manifest("quick", {})
    budget = replace(own.settings.final, episodes=3)
    assert of(run, replace(own, settings=replace(own.settings, final=budget))) is None
    assert of(run, replace(own, preset="custom")) is None


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({}, "--model ollama:m"),
        ({"server": "http://here/v1"}, "--base-url http://here/v1 --model ollama:m"),
        ({"server": "http://here", "model": "m:8b"}, "--base-url http://here --model m:8b"),
        ({"server": "http://here", "model": "compatible:m"}, "--base-url http://here --model m"),
        ({"diversity": False, "vision": True}, "--model ollama:m --no-diversity --vision"),
        ({"repairs": 5}, "--model ollama:m --repairs 5"),
        ({"replayed": "content"}, None),
    ],
)
def test_the_command_names_the_language_model(
    run: Run, changed: dict[str, Any], words: str | None
) -> None:
    plain = LLMSettings()
    settings = {
        "model": "ollama:m",
        "server": "",
        "vision": False,
        "diversity": plain.diversity,
        "repairs": plain.repairs,
        "history": {"tokens": plain.history.tokens, "rule": plain.history.rule},
        "sampling": {
            "seed": None,
            "temperature": None,
            "effort": None,
            "max_output_tokens": None,
        },
        **changed,
    }
    own = replace(manifest("quick", {}), designer="llm", designer_settings=settings)
    expected = words and f"robomore run ant --preset quick --designer llm {words} --seed 3"
    assert of(run, own) == expected


def test_the_budget_of_the_search_is_said(tmp_path: Path) -> None:
    fake = FakeRun(tmp_path)
    best = fake.coarse()
    for budget in (20_000, 30_000):
        with closing(Ledger(fake.folder.ledger)) as ledger:
            note_budget(ledger, fake.manifest.plan, budget, tmp_path)
    fake.final(best)
    run = load_run(tmp_path)
    # The last one: with it, the search goes on where the first ended it.
    command = of(run, manifest("quick", {}))
    assert command == "robomore run ant --preset quick --designer offline --seed 3 " + (
        "--budget-steps 30000"
    )
    assert as_data(run)["budget_steps"] == 30_000
    page = render(run)
    assert "whose budget was 30,000" in page and "budget steps 30,000 · method" in page


def test_a_task_file_is_not_called_by_its_id(tmp_path: Path) -> None:
    finished_run(tmp_path)
    run = load_run(tmp_path)
    assert "robomore run ant --preset" in str(of(run, manifest("quick", {})))
    (tmp_path / "task.json").touch()
    assert f"robomore run {TASK_FILE} --preset" in str(of(run, manifest("quick", {})))


def test_starts_without_a_file_have_no_command(run: Run) -> None:
    drawn = replace(manifest("quick", {}), starts=(Start("robot.json", Morphology((1.0,))),))
    assert "--start-from robot.json" in str(of(run, drawn))
    given = checked_starts(run.task, [Morphology(run.task.reference)])
    assert of(run, replace(drawn, starts=given)) is None
