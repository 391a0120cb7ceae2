"""An own task that was edited is another task: its old folder is refused, and its keys are new."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import untrained  # noqa: F401  # known as an executor once it is imported
from robomore import load_run, run
from robomore.errors import RunFolderError
from robomore.settings import preset, with_method
from robomore.tasks import TASKS, Task, get_task
from robomore.tasks.fingerprint import task_key

SWIMMER = get_task("swimmer")
ROBOT = "from robomore.envs.robots.swimmer import SwimmerEnvironment as Own\n"


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Task:
    """A task of a user, whose environment is a file of theirs."""
    (tmp_path / "own_robot.py").write_text(ROBOT)
    monkeypatch.syspath_prepend(tmp_path)
    task = replace(SWIMMER, id="own-swimmer", environment="own_robot:Own")
    monkeypatch.setitem(TASKS._items, task.id, task)
    return task


def search(task: Task, out: Path) -> None:
    run(task, with_method(preset("smoke"), "random"), executor="untrained", out=out)


EDITS: dict[str, Callable[[Task], Task]] = {
    "template": lambda task: replace(task, template=task.template.replace("4000", "3000")),
    "reward": lambda task: replace(task, reward=task.reward + "\n# tried something\n"),
    "options": lambda task: replace(task, options=lambda values: {"reset_noise_scale": 0.2}),
    "fitness": lambda task: replace(task, fitness="height"),
    "environment": lambda task: replace(task),
}


@pytest.mark.parametrize("part", EDITS)
def test_the_old_folder_is_refused_and_the_part_is_named(
    part: str, own: Task, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "run"
    search(own, out)
    search(own, out)  # The same task goes on.
    before = {evaluation.key for evaluation in load_run(out).evaluations}

    if part == "environment":
        (tmp_path / "own_robot.py").write_text(ROBOT + "\nOwn.healthy = True\n")
    edited = EDITS[part](own)
    monkeypatch.setitem(TASKS._items, own.id, edited)
    assert task_key(edited) != task_key(own)
    with pytest.raises(RunFolderError, match=rf"own-swimmer was edited since \(.*{part}"):
        search(edited, out)
    assert load_run(out).task_changes and load_run(out).warnings[0].startswith("The task own")

    search(edited, tmp_path / "anew")
    assert not before & {evaluation.key for evaluation in load_run(tmp_path / "anew").evaluations}
