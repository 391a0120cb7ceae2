"""Proposed motors carry the robot that they are for, and their file says what they follow from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from robomore.envs.vector_env import VectorEnv
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.task_file import read_task_file


def leg(name: str, y: float) -> str:
    """Return a leg of two links of 0.25 m with a flat foot; bent, it rests above the foot."""
    return f"""
      <body name="{name}_thigh" pos="0 {y} -0.05">
        <joint name="{name}_hip" axis="0 1 0" range="-60 60"/>
        <geom type="capsule" size="0.03" fromto="0 0 0 0 0 -0.25" mass="1"/>
        <body name="{name}_shin" pos="0 0 -0.25">
          <joint name="{name}_knee" axis="0 1 0" range="0 120"/>
          <geom type="capsule" size="0.025" fromto="0 0 0 0 0 -0.25" mass="0.7"/>
          <body name="{name}_foot" pos="0 0 -0.25">
            <joint name="{name}_ankle" axis="0 1 0" range="-45 45"/>
            <geom type="box" size="0.08 0.03 0.015" pos="0.03 0 -0.02" mass="0.3"/>
          </body>
        </body>
      </body>"""


POSE = " ".join(["-0.25 0.5 -0.25"] * 2)

BIPED = f"""<mujoco model="biped">
  <compiler angle="degree" autolimits="true"/>
  <worldbody>
    <body name="torso" pos="0 0 0.6">
      <freejoint name="root"/>
      <geom type="box" size="0.08 0.12 0.1" pos="0 0 0.05" mass="5.5"/>
      {leg("L", 0.09)}{leg("R", -0.09)}
    </body>
  </worldbody>
  <keyframe><key name="home" qpos="0 0 0.6 1 0 0 0 {POSE}"/></keyframe>
</mujoco>
"""

STILTS = """<mujoco model="stilts"><worldbody><body name="torso" pos="0 0 1">
  <freejoint name="root"/>
  <geom type="box" size="0.1 0.1 0.1" mass="4"/>
  <body name="left"><joint name="left_hip" axis="0 1 0" range="-1 1" limited="true"/>
    <geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.4" mass="0.5"/></body>
  <body name="right"><joint name="right_hip" axis="0 1 0" range="-1 1" limited="true"/>
    <geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.4" mass="0.5"/></body>
</body></worldbody></mujoco>
"""


def proposed(folder: Path, text: str) -> Path:
    robot = folder / "robot.xml"
    robot.write_text(text)
    return write_proposal(read_robot(robot), robot, folder / "task")


def test_a_biped_stands_on_its_ankles(tmp_path: Path) -> None:
    task = read_task_file(proposed(tmp_path, BIPED)).task
    env = VectorEnv(task, task.reference, 1, auto_reset=False)
    env.reset_one(0, 0)
    height = env.qpos[0][2]
    for _ in range(150):  # 3 s; with ankles of 4 N·m it fell after 1 s
        env.step(np.zeros((1, env.action_size)))
    assert env.qpos[0][2] > 0.95 * height


def test_the_file_says_what_the_strength_follows_from(tmp_path: Path) -> None:
    text = proposed(tmp_path, BIPED).read_text()
    ankle = text[text.index('joints = ["L_ankle", "R_ankle"]') :]
    assert "torque = 18  # N·m: 2.5 times what holds up 1/2 of 9.5 kg at" in ankle
    assert "a quarter of its leg" in ankle.partition("armature")[0]
    assert "a quarter" not in text.partition('joints = ["L_ankle')[0]


def test_the_ankles_strength_grows_with_mass_and_with_the_leg(tmp_path: Path) -> None:
    def ankle(text: str, name: str) -> float:
        folder = tmp_path / name
        folder.mkdir()
        motors = read_task_file(proposed(folder, text)).plan.motors
        return next(one.torque for one in motors if "L_ankle" in one.joints)

    heavy = BIPED.replace('mass="5.5"', 'mass="15"')
    long = BIPED.replace("0 0 -0.25", "0 0 -0.5")
    usual = ankle(BIPED, "usual")
    assert ankle(heavy, "heavy") == pytest.approx(2 * usual, rel=0.03)
    assert ankle(long, "long") == pytest.approx(2 * usual, rel=0.15)


def test_a_leg_of_one_link_is_as_long_as_its_solid(tmp_path: Path) -> None:
    (group,) = read_task_file(proposed(tmp_path, STILTS)).plan.motors
    assert group.torque == pytest.approx(2.5 * 5 * 9.81 * 0.4 / 2, rel=0.02)
