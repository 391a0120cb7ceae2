"""`new` and `check-task` say what was understood, before anything trains."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from cli.commands import Command
from dog import DOG, write_arm, write_dog
from tripod import STEADY, TRIPOD, write_tripod


def test_a_robot_that_moves_is_said_to_move(tmp_path: Path, robomore_: Command) -> None:
    said = robomore_("new", write_dog(tmp_path), "--out", tmp_path / "dog")
    assert said.status == 0 and "its base moves freely; its goal is `distance`" in said.words
    task = tmp_path / "dog" / "task.toml"
    assert "`RR_knee`: at rest -1.8 rad, the middle of its range -2.7 to -0.9" in said.words
    assert "reach = 0.35" in task.read_text(), "servos learn small motions sooner"
    assert "its base moves freely" in robomore_("check-task", task).words


def test_a_forgotten_free_joint_is_told(tmp_path: Path, robomore_: Command) -> None:
    said = robomore_("new", write_arm(tmp_path), "--base", "fixed", "--out", tmp_path / "arm").words
    assert "its base is fixed to the world" in said and "its goal is `target-reached`" in said
    assert "give its root a <freejoint/>" in said and "--base free" in said


def test_motors_that_the_file_lacks_are_told_and_its_own_keep_their_torque(
    tmp_path: Path, robomore_: Command
) -> None:
    head, _, tail = DOG.partition("<actuator>")
    tail = tail.partition("</actuator>")[2]
    without = write_dog(tmp_path, head + tail)
    said = robomore_("new", without, "--out", tmp_path / "without").words
    assert "added by the task file: a servo of" in said and "FL_hip" in said
    motors = "".join(f'<motor joint="{leg}_hip" gear="30"/>' for leg in ("FL", "FR", "RL", "RR"))
    own = write_dog(tmp_path, f"{head}<actuator>{motors}</actuator>{tail}")
    said = robomore_("new", own, "--out", tmp_path / "own").words
    assert "added by" not in said
    assert "reach" not in (tmp_path / "own" / "task.toml").read_text()


def test_a_keyframe_outside_of_a_range_is_told_by_both(tmp_path: Path, robomore_: Command) -> None:
    pose = " ".join(["0.8 -0.4", *["0.8 -1.6"] * 3])
    key = f'<keyframe><key name="home" qpos="0 0 0.3 1 0 0 0 {pose}"/></keyframe></mujoco>'
    robot = write_dog(tmp_path, DOG.replace("</mujoco>", key))
    said = robomore_("new", robot, "--out", tmp_path / "dog")
    assert said.status == 0 and "`FL_knee`: -0.4 became -0.9 rad" in said.words
    checked = robomore_("check-task", tmp_path / "dog" / "task.toml").words
    assert "`FL_knee`: rests at -0.9" in checked and "none of them holds the rest pose" in checked


def test_a_robot_that_diverges_is_told_by_both_with_what_cures_it(
    tmp_path: Path, robomore_: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    task = tmp_path / "made" / "task.toml"
    made = robomore_("new", write_tripod(tmp_path, TRIPOD), "--out", tmp_path / "made")
    files = set(tmp_path.iterdir())
    checked = robomore_("check-task", task)
    task.write_text(task.read_text().replace("reach = 0.35", "reach = 1.0"))
    far = robomore_("check-task", task)
    for said in (made, checked, far):
        assert said.status == 2 and "the reference robot: The physics diverged" in said.err
        assert '<joint armature="0.01" damping="0.2"/>' in said.err and "kp" in said.err
        assert 'timestep="0.0025"/>; it is 0.005 s now' in said.err and "WARNING" not in said.err
    assert made.err == checked.err and "robomore run" not in made.out
    assert set(tmp_path.iterdir()) == files, "MuJoCo writes no log"
    for number, text in enumerate((STEADY, TRIPOD.replace('"0.005"', '"0.001"'))):
        cured = robomore_("new", write_tripod(tmp_path, text), "--out", tmp_path / f"{number}")
        assert cured.status == 0 and "robomore run" in cured.out


def test_the_command_that_new_prints_fits_the_goal(tmp_path: Path, robomore_: Command) -> None:
    dog, arm = write_dog(tmp_path), write_arm(tmp_path)
    for robot, options, objective in (
        (dog, (), "--preset smoke"),
        (dog, ("--goal", "economy"), "--preset smoke --objective transport-economy"),
        (arm, ("--base", "fixed"), "--preset smoke --objective fitness"),
    ):
        said = robomore_("new", robot, *options, "--out", tmp_path / f"made{len(objective)}")
        assert said.out.endswith(f"task.toml {objective}\n")


def test_a_task_is_called_as_the_file_or_as_it_is_asked(
    tmp_path: Path, robomore_: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write_tripod(tmp_path, STEADY.replace('"tripod"', '"My walker"'))
    said = robomore_("new", "tripod.xml").words
    assert "as the file, which calls the robot 'My walker'; give --name for another" in said
    assert 'id = "tripod"' in (tmp_path / "tripod" / "task.toml").read_text()
    said = robomore_("new", "tripod.xml", "--name", "My walker").words
    text = (tmp_path / "my-walker" / "task.toml").read_text()
    assert 'id = "my-walker"\ntitle = "My Walker"' in text and "--name" not in said
    taken = robomore_("new", "tripod.xml", "--name", "ant")
    assert taken.status == 2 and "'ant' is the id of an installed task" in taken.err
    write_tripod(tmp_path)
    assert "--name" not in robomore_("new", "tripod.xml", "--out", "again").words


def test_a_task_file_that_is_none_is_told_as_what_it_is(
    tmp_path: Path, robomore_: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.toml")
    Path("task.toml").touch()
    assert "pipe.toml is a named pipe. Name a task file" in robomore_("check-task", "pipe.toml").err
    said = robomore_("check-task", "tsk.toml").err
    assert "there is no file tsk.toml. Did you mean 'task.toml'?" in said
