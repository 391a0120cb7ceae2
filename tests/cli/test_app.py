"""How every command ends: one line for a mistake, an exit status, no traceback."""

from __future__ import annotations

import importlib
import logging
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

import robomore.experiment
import robomore.registry
from cli.commands import Command
from robomore import __version__
from robomore.cli.app import COMMANDS
from robomore.errors import Interrupted, NothingTrained
from robomore.tasks import TASKS


@pytest.fixture
def files(tmp_path: Path, finished: Path) -> dict[str, Path]:
    """Files and folders that something is wrong with."""
    made = {
        "FINISHED": finished,
        "SHORT": tmp_path / "short.json",
        "LARGE": tmp_path / "large.json",
        "BROKEN": tmp_path / "broken.json",
        "TWICE": tmp_path / "twice.json",
        "DEEP": tmp_path / "deep.json",
        "FENCED": tmp_path / "fenced.py",
        "WORDS": tmp_path / "words.json",
        "BINARY": tmp_path / "binary.json",
        "TYPO": tmp_path / "typo.json",
        "BADREWARD": tmp_path / "bad.py",
        "EMPTY": tmp_path / "empty",
        "MISSING": tmp_path / "missing",
        "BEHINDFILE": tmp_path / "short.json" / "run",
        "NOPOLICY": tmp_path / "nopolicy",
    }
    made["SHORT"].write_text("[1, 2]")
    made["LARGE"].write_text("[99, 1, 1, 0.1, 0.1, 0.1]")
    made["BROKEN"].write_text("[1, 2")
    made["TWICE"].write_text('{"front_length": 1, "front_length": 2}')
    made["DEEP"].write_text(100_000 * "[")
    made["FENCED"].write_text("```python\ndef _get_rew(self, x_velocity, action): pass\n```\n")
    made["WORDS"].write_text('["a", "b", "c", "d", "e", "f"]')
    made["BINARY"].write_bytes(b"\xff\xfe\x00")
    made["TYPO"].write_text('{"front_lenght": 1}')
    made["BADREWARD"].write_text("def _get_rew(self, x_velocity, action)\n    return 1")
    made["EMPTY"].mkdir()
    made["NOPOLICY"].mkdir()
    (made["NOPOLICY"] / "design.json").write_bytes(
        (finished / "champion" / "design.json").read_bytes()
    )
    return made


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        ("run nope", "no task is called 'nope'"),
        ("inspect swimer", "Did you mean 'swimmer'?"),
        ("run swimmer --preset quik", "Did you mean 'quick'? Choose one of smoke, quick"),
        ("run swimmer --preset smoke --designer nobody", "nobody"),
        ("run swimmer --workers 0", "--workers is 0"),
        ("run swimmer --final-steps 0", "--final-steps is 0"),
        ("run swimmer --objective speed", "efficiency"),
        ("run swimmer --trainer ppo", "Choose one of crossq, sac, sb3"),
        ("run swimmer --trainer-option net_arch", "batch_size=512, for example"),
        (
            "run swimmer --trainer sac --trainer-option net_ach=[8]",
            "no option 'net_ach'. Did you mean 'net_arch'?",
        ),
        ("run swimmer --method annealing", "no method is called 'annealing'"),
        ("run swimmer --method-option samples", "morphologies=10, for example"),
        ("run swimmer --method-option samples=3", "has no option 'samples'. It takes"),
        ("run swimmer --method-option rewards=many", "rewards"),
        ("run swimmer --method random --reference-reward in", "no option reference_reward"),
        ("run swimmer --reference-reward maybe", "reference-reward"),
        ("run swimmer --method random --designer offline", "asks no designer"),
        ("run swimmer --executor cloud", "no executor is called 'cloud'"),
        ("run swimmer --budget-steps 100", "larger --budget-steps"),
        ("run swimmer --time-limit soon", "write 90s, 30m or 2h"),
        ("run swimmer --time-limit 0", "write 90s, 30m or 2h"),
        ("run swimmer --seed 1.5", "--seed is 1.5; give a whole number"),
        ("play runs --seconds 0.2", "--seconds is 0.2; give a whole number"),
        ("methods cmeas", "Did you mean 'cmaes'"),
        ("run swimmer --time-limit 5", "no unit; write 5s, 5m or 5h"),
        ("run swimmer --time-limit -5", "--time-limit"),
        ("run swimmer --seed -1", "--seed is -1"),
        ("run swimmer --finalists 0", "--finalists is 0"),
        ("run swimmer --final-seeds 0", "--final-seeds is 0"),
        ("run swimmer --cycles 3", "--cycles"),
        ("evaluate swimmer --seed -1", "--seed is -1"),
        ("run swimmer --trainer-option batch_size=many", "batch_size"),
        ("run swimmer --preset smoke --trainer sac", "learns nothing in 2048 steps"),
        ("run swimmer --preset smoke --out BEHINDFILE", "--out"),
        ("run ant --preset smoke --out FINISHED", "'swimmer' there and 'ant' here"),
        ("inspect swimmer --parameters SHORT", "short.json: swimmer: 2 parameters given, it"),
        ("inspect swimmer --parameters LARGE", "front_length = 99 m is outside"),
        ("inspect swimmer --parameters BROKEN", "is not JSON"),
        ("inspect swimmer --parameters TWICE", "'front_length' stands there more than once"),
        ("inspect swimmer --parameters DEEP", "is not JSON"),
        ("evaluate swimmer --reward FENCED", "leave out the lines of ```"),
        ("inspect swimmer --parameters WORDS", 'is "a", which is not a number'),
        ("inspect swimmer --parameters TYPO", "unknown 'front_lenght'"),
        ("inspect swimmer --parameters BINARY", "no text in UTF-8"),
        ("inspect swimmer --parameters MISSING", "cannot be read"),
        ("inspect swimmer --picture EMPTY/a.bmp", "end it in .svg or .png"),
        ("evaluate swimmer --parameters LARGE", "front_length = 99 m is outside"),
        ("evaluate swimmer --reward BADREWARD", "line 1: does not parse"),
        ("evaluate swimmer --reward EMPTY", "cannot be read"),
        ("evaluate swimmer --steps 0", "--steps is 0"),
        ("evaluate swimmer --trainer ppo", "Choose one of crossq, sac, sb3"),
        ("evaluate swimmer --trainer-option batch_size=0", "batch_size"),
        ("evaluate swimmer --steps 300", "learns nothing in 300 steps"),
        ("evaluate swimmer --out FINISHED", "is not empty"),
        ("evaluate swimmer --out BEHINDFILE", "cannot write"),
        ("show EMPTY", "not a run folder"),
        ("report MISSING", "there is no folder"),
        ("audit MISSING", "there is no folder"),
        ("serve MISSING", "there is no folder"),
        ("play SHORT", "short.json is a file; name a folder that"),
        ("report FINISHED --out EMPTY/no/page.html", "cannot write"),
        ("play EMPTY", "neither a run folder nor a design"),
        ("play NOPOLICY", "train it: robomore evaluate swimmer"),
        ("play FINISHED --out a.avi", "end it in .mp4, .webp or .gif"),
        ("run", "TASK"),
        ("run swimmer --seed x", "--seed"),
        ("run swimmer --nonsense", "--nonsense"),
        ("rnu swimmer", "rnu"),
    ],
)
def test_every_mistake_is_one_line_and_status_2(
    robomore_: Command,
    files: dict[str, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: str,
    expected: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, path in files.items():
        command = command.replace(name, str(path))
    said = robomore_(*command.split())
    assert expected in said.err
    assert said.err.startswith("robomore: ")
    assert said.err.count("\n") == 1
    assert said.out == ""
    assert said.status == 2
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("error", "status", "expected"),
    [
        (Interrupted("stopped; 3 evaluations are kept"), 130, "3 evaluations are kept"),
        (KeyboardInterrupt(), 130, "stopped"),
        (NothingTrained("all 4 candidates failed"), 1, "all 4 candidates failed"),
        (OSError(28, "No space left on device"), 1, "No space left"),
        (ModuleNotFoundError("No module", name="cmaes"), 1, "'cmaes' is missing; install"),
        (ZeroDivisionError("division\nby zero"), 1, "--debug"),
    ],
)
def test_how_work_that_fails_ends(
    robomore_: Command,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    error: BaseException,
    status: int,
    expected: str,
) -> None:
    monkeypatch.chdir(tmp_path)

    def run(*_: Any, **__: Any) -> None:
        raise error

    monkeypatch.setattr(robomore.experiment, "run", run)
    said = robomore_("run", "swimmer")
    assert said.status == status
    assert expected in said.err
    assert said.err.count("\n") == 1
    assert "Traceback" in robomore_("run", "swimmer", "--debug").err


def test_sigterm_is_ctrl_c(
    robomore_: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    before = signal.getsignal(signal.SIGTERM)

    def run(*_: Any, **__: Any) -> None:
        os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(robomore.experiment, "run", run)
    assert robomore_("run", "swimmer").status == 130
    assert signal.getsignal(signal.SIGTERM) is before


def test_help_loads_nothing_heavy() -> None:
    script = (
        "import sys; from robomore.cli import main; status = main(['--help']);"
        "heavy = {'mujoco', 'numpy', 'jax', 'gymnasium', 'matplotlib'} & set(sys.modules);"
        "sys.exit(f'loaded {heavy}' if heavy else status)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "inspect" in done.stdout


def test_a_broken_plugin_is_one_warning_and_all_else_works(
    robomore_: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = EntryPoint("tortoise", "no.such.module:TASK", "robomore.tasks")
    monkeypatch.setattr(
        robomore.registry,
        "entry_points",
        lambda group: [broken] if group == broken.group else [],
    )
    monkeypatch.setattr(TASKS, "_warned", set())
    TASKS.__dict__.pop("_plugins", None)
    try:
        said = robomore_("tasks")
        assert said.status == 0 and "half-cheetah" in said.out
        assert said.err.startswith("robomore: warning: the task tortoise") and "mend" in said.err
        assert said.err.count("\n") == 1
        assert robomore_("inspect", "swimmer").err == ""
        said = robomore_("inspect", "tortoise")
        assert said.status == 2 and "does not load" in said.err and said.err.count("\n") == 1
    finally:
        TASKS.__dict__.pop("_plugins", None)


def test_warnings_are_lines_while_a_command_runs_and_not_after(
    robomore_: Command, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(*_: Any, **__: Any) -> None:
        logging.getLogger("robomore.somewhere").warning("a thing\nof two lines")
        raise NothingTrained("no")

    monkeypatch.setattr(robomore.experiment, "run", run)
    said = robomore_("run", "swimmer")
    assert said.err == "robomore: warning: a thing of two lines\nrobomore: no\n"
    assert not logging.getLogger("robomore").handlers


@pytest.mark.parametrize("flag", ["-V", "--version"])
def test_the_version(robomore_: Command, flag: str) -> None:
    said = robomore_(flag)
    assert (said.status, said.out.strip()) == (0, __version__)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_says_what_it_does(robomore_: Command, name: str) -> None:
    said = robomore_(name, "--help")
    assert said.status == 0 and f"robomore {name}" in said.out
    listed = next(line for line in robomore_("--help").out.splitlines() if f" {name} " in line)
    assert COMMANDS[name][1] in listed, "its line of help fits one line"


def paragraphs(text: str) -> Iterator[list[str]]:
    """Yield the lines of each text in a help at 80 columns, without boxes and names of options."""
    found: list[str] = []
    for line in text.splitlines():
        inside = line.strip("│ ")
        column = re.match(r"│(?: \*)? {1,4}[\w-][^│]*?  +(?=\S)", line)
        if not inside or line[0] in "╭╰" or column:
            yield found
            found = []
        found += [line[column.end() :].strip("│ ")] if column else [inside] if inside else []
    yield found


@pytest.mark.parametrize("name", COMMANDS)
def test_the_lines_of_a_help_are_full(
    robomore_: Command, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    said = robomore_(name, "--help").out
    assert said.startswith(f"Usage: robomore {name}")
    assert max(map(len, said.splitlines())) <= 80
    for lines in paragraphs(said):
        widest = max(map(len, lines), default=0)
        for line, after in pairwise(lines):
            word = after.split()[0]
            assert len(line) + 1 + len(word) > widest, f"{line!r} has room for {word!r}"


def test_each_command_that_takes_a_task_takes_its_file(robomore_: Command) -> None:
    for name in ("run", "inspect", "evaluate", "prompt", "check-reward", "check-task", "study"):
        said = " ".join(robomore_(name, "--help").out.replace("│", " ").split())
        assert re.search(r"path of (a|its) task file \(\.toml\)|paths of task files", said, re.I)


def test_words_that_people_did_not_understand_are_gone(robomore_: Command) -> None:
    text = " ".join(robomore_(name, "--help").out for name in COMMANDS)
    for words in ("human", "stranger", "body", "bodies", "implied", "under a minute", "fell share"):
        assert words not in text.lower()


def test_a_graphics_driver_that_is_missing_is_named(
    robomore_: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    # As PyOpenGL fails when MuJoCo is imported without the library that `MUJOCO_GL` names.
    (tmp_path / "OpenGL").mkdir()
    (tmp_path / "OpenGL" / "broken.py").write_text("def find():\n    return None.glGetError\n")
    monkeypatch.syspath_prepend(tmp_path / "OpenGL")
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    broken = importlib.import_module("broken")
    monkeypatch.setattr("robomore.cli.methods.methods", lambda: broken.find())
    said = robomore_("methods")
    assert said.status == 2 and "MUJOCO_GL=osmesa does not work" in said.err
    assert "libosmesa6" in said.err and said.err.count("\n") == 1
