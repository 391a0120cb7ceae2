"""Robots that others made, from their file to a champion without an edit: `make test-robots`."""

from __future__ import annotations

import importlib.util
import itertools
import re
import shlex
import shutil
from pathlib import Path

import pytest

from robomore.cli.app import main
from robomore.runs import load_run

pytestmark = pytest.mark.robots

ROBOTS = {
    "go1": ("mjlab", "asset_zoo/robots/unitree_go1/xmls/go1.xml"),
    "g1": ("mjlab", "asset_zoo/robots/unitree_g1/xmls/g1.xml"),
    "quadruped": ("dm_control", "suite/quadruped.xml"),
    "upkie": ("upkie_description", "urdf/upkie.urdf"),
    "ur5e": ("ogbench", "manipspace/descriptions/universal_robots_ur5e/ur5e.xml"),
}
"""Package and file of each robot. None of the packages is imported."""


def file_of(name: str) -> Path:
    """Return a robot's file, or skip the test."""
    package, inside = ROBOTS[name]
    found = importlib.util.find_spec(package)
    if found is None or not found.submodule_search_locations:
        pytest.skip(f"{package} is not installed; make test-robots does that")
    return Path(found.submodule_search_locations[0]) / inside


@pytest.mark.parametrize("name", ROBOTS)
def test_from_a_file_to_a_champion(name: str, tmp_path: Path) -> None:
    folder, run = tmp_path / name, tmp_path / "run"
    assert main(["new", str(file_of(name)), "--out", str(folder)]) == 0
    file = folder / "task.toml"
    assert main(["run", str(file), "--preset", "smoke", "--out", str(run), "--workers", "1"]) == 0
    champion = load_run(run).champion
    assert champion is not None and (run / "champion" / "policy.npz").is_file()


STORY = Path(__file__).parents[2] / "docs" / "own-robot.md"
KEPT = ("--method", "--method-option", "--objective", "--seed", "--out")
SMALL = {
    "run": "--preset smoke --evaluations 3",
    "evaluate": "--preset smoke",
}
"""What is trained is small, so that the story takes a minute; all else is as it stands there."""


def test_every_command_of_the_story_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The commands of the document in their order, on Go1, with a smaller search."""
    shutil.copytree(file_of("go1").parent, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```sh\n(.*?)```", STORY.read_text(encoding="utf-8"), re.DOTALL)
    lines = [line for block in blocks for line in block.replace("\\\n", " ").splitlines()]
    commands = [shlex.split(line)[1:] for line in lines if line.startswith("robomore ")]
    names = [words[0] for words in commands]
    assert {"new", "check-task", "run", "evaluate", "inspect", "play"} <= set(names)
    for words in commands:
        if words[0] in ("run", "evaluate"):
            given = dict(itertools.pairwise(words))
            kept = [word for name in KEPT if name in given for word in (name, given[name])]
            words = [*words[:2], *kept, *shlex.split(SMALL[words[0]])]
        if words[0] == "play":
            words += ["--seconds", "1", "--drawn"]
        assert main(words) == 0, words
