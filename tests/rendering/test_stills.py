"""Small pictures of a page: capsules, and boxes as boxes."""

from __future__ import annotations

from pathlib import Path

import pytest

from dog import write_dog
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.rendering.stills import still
from robomore.tasks import get_task


def test_a_box_is_told_with_its_sides_and_its_orientation(tmp_path: Path) -> None:
    robot = write_dog(tmp_path)
    task = get_task(str(write_proposal(read_robot(robot), robot, tmp_path / "task")))
    solids, _ = still(task, task.reference)
    (trunk,) = [one for one in solids if len(one) == 15]
    assert trunk[8:] == pytest.approx([0.2, 0.05, 0.05, 1, 0, 0, 0])
    middle = [(trunk[n] + trunk[n + 3]) / 2 for n in range(3)]
    assert middle[:2] == pytest.approx([0, 0]) and middle[2] > 0.2
    assert {len(one) for one in solids} == {8, 15}
    swimmer = get_task("swimmer")
    assert {len(one) for one in still(swimmer, swimmer.reference)[0]} == {8}
