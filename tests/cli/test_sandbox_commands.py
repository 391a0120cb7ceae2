"""`doctor` and `check-reward`: what they say, and how they end."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from robomore.cli.app import main
from robomore.sandbox.restrictions import REQUIRED


def test_doctor_names_every_layer(capsys: pytest.CaptureFixture[str]) -> None:
    status = main(["doctor", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert status == (0 if told["strict"] else 1)
    assert set(REQUIRED) <= {layer["name"] for layer in told["layers"]}
    assert all(layer["detail"] for layer in told["layers"])


def test_check_reward_names_file_line_and_remedy(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "reward.py"
    file.write_text("import os\n\ndef _get_rew(self, x_velocity, action):\n    return 1.0, {}\n")
    assert main(["check-reward", "ant", str(file)]) == 1
    assert f"{file}:1: error: cannot import `os`" in capsys.readouterr().out


def test_a_sound_reward_passes(tmp_path: Path) -> None:
    file = tmp_path / "reward.py"
    file.write_text("def _get_rew(self, x_velocity, action):\n    return x_velocity, {}\n")
    assert main(["check-reward", "ant", str(file)]) == 0


def test_a_missing_file_is_misuse(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check-reward", "ant", "nowhere.py"]) == 2
    assert "nowhere.py cannot be read" in capsys.readouterr().err
