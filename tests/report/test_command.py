"""The command in a report gives the run's own settings back."""

from __future__ import annotations

import shlex
from dataclasses import replace

import pytest

from robomore.report.command import command_line, overridden, settings_name
from robomore.settings import preset
from robomore.store import Manifest


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


def test_final_trainings_keep_their_proportion() -> None:
    settings = overridden(preset("standard"), {"steps": 1_000})
    assert (settings.candidate.steps, settings.final.steps) == (1_000, 2_000)


def test_settings_that_no_option_reaches_have_no_command() -> None:
    own = manifest({})
    trainer = replace(own.settings.trainer, name="another")
    assert command_line(replace(own, settings=replace(own.settings, trainer=trainer))) is None
    assert command_line(replace(own, preset="custom")) is None
