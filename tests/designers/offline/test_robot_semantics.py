"""What a reward reads of a robot's root, whatever the order of its joints and its rest."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from robomore.designers.offline.robot_semantics import robot_semantics
from robomore.envs.reward_text import reward_function
from robomore.envs.robots.own_robot import OwnRobotEnvironment
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.task_file import read_task
from robomore.tasks.task import Task

LEG = """<mujoco><worldbody><body name="torso" {place}>{root}
<geom type="box" size="0.1 0.1 0.1"/>
<body name="thigh"><joint name="hip" axis="0 1 0" range="-60 60"/>
<geom name="thigh" type="capsule" size="0.04" fromto="{leg}"/></body></body></worldbody>
<actuator><motor joint="hip" gear="20" ctrlrange="-1 1"/></actuator></mujoco>"""


def task(folder: Path, text: str) -> Task:
    source = folder / "leg.xml"
    source.write_text(text)
    return read_task(write_proposal(read_robot(source), source, folder / "task"))


def test_the_slides_of_a_planar_root_may_stand_in_any_order(tmp_path: Path) -> None:
    root = (
        '<joint name="z" type="slide" axis="0 0 1"/><joint name="x" type="slide" axis="1 0 0"/>'
        '<joint name="y" type="hinge" axis="0 1 0"/>'
    )
    text = LEG.format(place='pos="0 0 1"', root=root, leg="0 0 0 0 0 -0.4")
    read = robot_semantics(task(tmp_path, text)).expressions
    assert (read["height"], read["lift"]) == ("self.data.qpos[0]", "self.data.qvel[0]")
    assert read["tip"] == "self.data.qvel[2]"
    assert "sideways" not in read and "offset" not in read


@pytest.mark.parametrize("quat", ["0.7 0.7 0 0", "1 0.5 0 0"])
def test_the_slides_of_a_turned_root_are_not_the_world_s(tmp_path: Path, quat: str) -> None:
    root = (
        '<joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1"/>'
        '<joint name="y" type="hinge" axis="0 1 0"/>'
    )
    planar = task(tmp_path, LEG.format(place='pos="0 0 1"', root=root, leg="0 0 0 0 0 -0.4"))
    assert "height" in robot_semantics(planar).expressions
    (before,) = re.findall(r'<body name="torso"[^>]*>', planar.template)
    template = planar.template.replace(before, before.replace(">", f' quat="{quat}">'))
    assert "height" not in robot_semantics(replace(planar, template=template)).expressions


def test_a_root_that_is_turned_at_rest_is_upright_there(tmp_path: Path) -> None:
    place = 'pos="0 0 1" quat="0.70710678 0.70710678 0 0"'
    text = LEG.format(place=place, root="<freejoint/>", leg="0 0 0 0 -0.4 0")
    turned = task(tmp_path, text)
    read = robot_semantics(turned).expressions
    assert "tip" not in read, "its own y is not the world's"
    values = turned.reference
    env = OwnRobotEnvironment(turned, values, reward_function(turned.reward), reset_noise=0.0)
    env.reset(seed=0)
    for name in ("up", "heading"):
        assert eval(read[name], {"np": np, "self": env}) == pytest.approx(1.0, abs=1e-3)
