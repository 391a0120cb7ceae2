"""The command in a report gives the run's own settings back."""

from __future__ import annotations

import shlex
from dataclasses import replace

import pytest

from robomore.report.command import command_line, overridden, settings_name
from robomore.settings import preset, with_trainer
from robomore.store import Manifest
from robomore.types import TrainerSettings


def manifest(options: dict[str, object]) -> Manifest:
    settings = overridden(preset("quick"), options)
    return Manifest("ant", 1, settings_name("quick", options), "offline", "", 3, settings)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"steps": 5_000},
        {"steps": 5_000, "final-steps": 7_000},
        {"objective": "fitness", "morphologies": 2, "cycles": 1},
        {"steps": 5_000, "trainer": "sac"},
    ],
)
def test_the_command_names_what_differs_from_the_preset(options: dict[str, object]) -> None:
    command = command_line(manifest(options))
    assert command is not None
    words = shlex.split(command)
    expected = ["robomore", "run", "ant", "--preset", "quick", "--designer", "offline"]
    assert words[:9] == [*expected, "--seed", "3"]
    given = dict(zip(words[9::2], words[10::2], strict=True))
    assert given == {f"--{name}": str(value) for name, value in options.items()}


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"trainer-option": {"batch_size": 64}}, ["--trainer-option", "batch_size=64"]),
        ({"trainer-option": {"batch_size": 64}}, ["--trainer-option", "batch_size=64"]),
        (
            {"trainer": "sac", "trainer-option": {"hidden": [64, 64], "target_entropy": None}},
            [
                *("--trainer", "sac", "--trainer-option", "hidden=[64, 64]"),
                *("--trainer-option", "target_entropy=null"),
            ],
        ),
    ],
)
def test_the_command_names_trainer_and_options(given: dict[str, object], words: list[str]) -> None:
    command = command_line(manifest(given))
    assert command is not None
    assert shlex.split(command)[9:] == ["--seed", "3", *words][2:]


def test_a_folder_can_be_named_after_any_option() -> None:
    options = {"trainer": "sac", "trainer-option": {"hidden": [64, 64], "target_entropy": -2.5}}
    assert settings_name("quick", options) == "quick-trainersac-hidden_64_64-target_entropy-2.5"


def test_another_trainer_starts_from_its_own_defaults() -> None:
    smoke = preset("smoke")
    assert smoke.trainer.options
    assert with_trainer(smoke, "sac").trainer == TrainerSettings("sac", {})
    same = with_trainer(smoke, smoke.trainer.name, {"rate": 1e-4}).trainer
    assert same.options == {**smoke.trainer.options, "rate": 1e-4}


def test_final_trainings_keep_their_proportion() -> None:
    settings = overridden(preset("standard"), {"steps": 1_000})
    assert (settings.candidate.steps, settings.final.steps) == (1_000, 2_000)


def test_settings_that_no_option_reaches_have_no_command() -> None:
    own = manifest({})
    budget = replace(own.settings.final, episodes=3)
    assert command_line(replace(own, settings=replace(own.settings, final=budget))) is None
    assert command_line(replace(own, preset="custom")) is None
