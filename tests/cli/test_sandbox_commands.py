"""`doctor` and `check-reward`: what they say, and how they end."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cli.commands import Command
from robomore.cli.app import main
from robomore.rewards.dry_run import DryRun, DryRunResult
from robomore.rewards.finding import Finding
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
    told = capsys.readouterr().out
    assert f"{file}:1: error: cannot import `os`" in told
    assert told.splitlines()[-1] == f"{file}: refused, with 1 error"


def test_a_sound_reward_passes_with_its_statistics(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "reward.py"
    file.write_text(
        "def _get_rew(self, x_velocity, action):\n    effort = float(np.square(action).sum())\n"
        "    return x_velocity - effort, {'speed': x_velocity, 'effort': -effort, 'spin': 0.0}\n"
    )
    assert main(["check-reward", "swimmer", str(file)]) == 0
    told = capsys.readouterr().out
    assert f"{file}:3: warning: 'spin' was 0 in all" in told and "one call takes" in told
    assert told.splitlines()[-1] == f"{file}: accepted, with 1 warning"
    table = told.splitlines()[2:6]
    assert [line.split()[0] for line in table] == ["(the", "speed", "effort", "spin"]
    assert main(["check-reward", "swimmer", str(file), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [found["severity"] for found in told["findings"]] == ["warning"]
    assert set(told["observed"]["terms"]) == {"speed", "effort", "spin"}


@pytest.mark.parametrize(
    ("lines", "line", "said"),
    [
        (["", "return float(np.sqare(action).sum()), {}"], 3, "no attribute 'sqare'"),
        (["return self.spec.max_episode_steps, {}"], 2, "`self.spec` is None"),
    ],
)
def test_what_only_a_try_shows_is_an_error_with_its_line(
    lines: list[str], line: int, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "reward.py"
    body = "\n".join(f"    {one}" for one in lines)
    file.write_text(f"def _get_rew(self, x_velocity, action):\n{body}\n")
    assert main(["check-reward", "swimmer", str(file)]) == 1
    told = capsys.readouterr().out
    assert f"{file}:{line}: error: " in told and said in told
    assert told.splitlines()[-1] == f"{file}: refused, with 1 error"


def test_what_was_not_tried_out_is_neither_accepted_nor_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    untried = DryRunResult([Finding(1, "note", "could not be tried out: no simulation")])
    monkeypatch.setattr(DryRun, "result", lambda self, source: untried)
    file = tmp_path / "reward.py"
    file.write_text("def _get_rew(self, x_velocity, action):\n    return x_velocity, {}\n")
    assert main(["check-reward", "swimmer", str(file)]) == 1
    assert capsys.readouterr().out.splitlines()[-1].startswith(f"{file}: neither accepted nor")


def test_a_missing_file_is_misuse(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check-reward", "ant", "nowhere.py"]) == 2
    assert "nowhere.py cannot be read" in capsys.readouterr().err


def test_a_task_s_own_reward_is_checked_by_its_name(
    robomore_: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    said = robomore_("check-reward", "swimmer", "reference")
    assert said.status == 0 and "600 calls" in said.words and "forward" in said.words, said
    Path("reward.py").touch()
    missing = robomore_("check-reward", "swimmer", "rewrd.py").err
    assert "(No such file or directory. Did you mean 'reward.py'?)" in missing
    assert "name a Python file, or `reference` for the task's own reward" in missing
