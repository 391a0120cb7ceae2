"""A rest pose outside of a range is told, and so is one that makes actions one-sided."""

from __future__ import annotations

from pathlib import Path

import pytest

from dog import DOG, write_dog
from robomore.errors import InputError
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.rest import home_notes
from robomore.importer.task_file import read_task_file
from tripod import STEADY, write_tripod

INSIDE = "0.8 -1.6"


def keyed(folder: Path, first_leg: str) -> Path:
    """Return a dog's file whose keyframe bends the first leg as given, and the others well."""
    pose = " ".join([first_leg, *[INSIDE] * 3])
    key = f'<keyframe><key name="home" qpos="0 0 0.3 1 0 0 0 {pose}"/></keyframe></mujoco>'
    return write_dog(folder, DOG.replace("</mujoco>", key))


def proposed(robot: Path, folder: Path) -> Path:
    return write_proposal(read_robot(robot), robot, folder)


@pytest.mark.parametrize(
    ("knee", "end"), [("0.4", "0.4 became -0.9 rad"), ("-3", "-3 became -2.7 rad")]
)
def test_a_keyframe_outside_of_a_range_is_told_and_its_task_is_accepted(
    tmp_path: Path, knee: str, end: str
) -> None:
    robot = read_robot(keyed(tmp_path, f"0.8 {knee}"))
    assert robot.home["FL_knee"] in (-0.9, -2.7) and robot.home["FL_hip"] == 0.8
    (note,) = [one for one in robot.notes if "keyframe" in one]
    assert f"`home` lies outside the range of joints: `FL_knee`: {end} (range -2.7 to -0.9)" in note
    assert "[home.joints]" in note and "`RR_knee`" not in note
    file = write_proposal(robot, tmp_path / "dog.xml", tmp_path / "task")
    assert f"# Note: {note}." in file.read_text()
    assert read_task_file(file).plan.home["FL_knee"] == robot.home["FL_knee"]


def test_a_pose_inside_every_range_is_not_told(tmp_path: Path) -> None:
    file = proposed(keyed(tmp_path, INSIDE), tmp_path / "task")
    assert not [note for note in read_task_file(file).notes if "range" in note]


def test_a_joint_that_cannot_rest_at_0_and_has_no_pose_is_told(tmp_path: Path) -> None:
    file = proposed(keyed(tmp_path, INSIDE), tmp_path / "task")
    lines = [one for one in file.read_text().splitlines() if not one.startswith("FL_knee =")]
    file.write_text("\n".join(lines))
    notes = " ".join(read_task_file(file).notes)
    assert "the rest pose lies outside the range of joints: `FL_knee`: 0 became -0.9 rad" in notes


def test_a_rest_pose_at_an_end_says_where_actions_go(tmp_path: Path) -> None:
    file = proposed(keyed(tmp_path, "0.8 -0.9"), tmp_path / "task")
    (note,) = [one for one in read_task_file(file).notes if "range" in one]
    assert "at an end of a control range" in note and "`FL_knee`: rests at -0.9" in note
    assert "-1.8, -1.49, so none of them holds the rest pose" in note
    assert "reach above 0.35" in note
    file.write_text(file.read_text().replace("reach = 0.35", "reach = 1.0"))
    (note,) = [one for one in read_task_file(file).notes if "range" in one]
    assert "none of them" not in note and "reach" not in note


def test_a_rest_pose_close_to_an_end_says_that_actions_are_one_sided(tmp_path: Path) -> None:
    file = proposed(keyed(tmp_path, "0.8 -1.0"), tmp_path / "task")
    (note,) = [one for one in read_task_file(file).notes if "range" in one]
    assert "nearly to one side only: `FL_knee`: actions -1, 0, 1" in note


def test_a_range_in_degrees_that_ends_between_six_digits_is_no_fault(tmp_path: Path) -> None:
    text = DOG.replace('angle="radian"', 'angle="degree"').replace("-2.7 -0.9", "-120 -30")
    text = text.replace('range="-0.7 2.5"', 'range="-40 120"')
    pose = " ".join(["0.8 -2.5"] * 4)
    key = f'<keyframe><key name="home" qpos="0 0 0.3 1 0 0 0 {pose}"/></keyframe></mujoco>'
    file = proposed(write_dog(tmp_path, text.replace("</mujoco>", key)), tmp_path / "task")
    assert "FL_knee = -2.0944\n" in file.read_text()
    assert not [note for note in read_task_file(file).notes if "outside the range" in note]
    file.write_text(file.read_text().replace("FL_knee = -2.0944", "FL_knee = -2.2"))
    with pytest.raises(InputError, match=r"FL_knee = -2.2, which is outside .* rad; give a number"):
        read_task_file(file)


def test_a_servo_without_a_range_is_told_the_range_of_its_joint(tmp_path: Path) -> None:
    def notes(text: str) -> list[str]:
        robot = write_tripod(tmp_path, text)
        file = write_proposal(read_robot(robot), robot, tmp_path / "task")
        return [note for note in read_task_file(file).notes if "control" in note]

    (note,) = notes(STEADY)
    assert "servos without a ctrlrange take controls from -1 to 1" in note
    assert "`L_knee`, `R_knee`, `B_knee`: actions -1, 0, 1 are the controls -0.35, 0, 0.35" in note
    assert 'give it ctrlrange="-2.2 -0.4" or inheritrange="1"' in note
    assert "rest pose" not in note and "_hip" not in note, "hips have the range -1 to 1"
    (note,) = notes(STEADY.replace('kp="30"', 'kp="30" gear="-2"'))
    assert 'give it ctrlrange="0.8 4.4"' in note and "inheritrange" not in note
    for cure in ('inheritrange="1"', 'ctrlrange="-2.2 -0.4"'):
        assert not notes(STEADY.replace('_knee" kp="30"', f'_knee" kp="30" {cure}'))


def test_a_pose_that_was_chosen_is_told_with_the_range(tmp_path: Path) -> None:
    robot = read_robot(write_tripod(tmp_path))
    knees, hips = home_notes(robot)
    assert knees.startswith("`L_knee`, `R_knee`, `B_knee`: at rest -1.3 rad, the middle of its")
    assert "range -2.2 to -0.4, which leaves out 0" in knees
    assert hips.startswith("`L_hip`, `R_hip`, `B_hip`: at rest 0.65 rad") and "-1 to 1" in hips
    file = write_proposal(robot, tmp_path / "tripod.xml", tmp_path / "task")
    assert "R_knee = -1.3  # the middle of its range -2.2 to -0.4" in file.read_text()
    assert not home_notes(read_robot(keyed(tmp_path, INSIDE))), "the keyframe said it"
