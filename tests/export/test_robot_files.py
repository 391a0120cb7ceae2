"""Robots as MJCF and URDF, read by MuJoCo alone and by a URDF reader that we did not write."""

from __future__ import annotations

import io
from pathlib import Path

import mujoco
import numpy as np
import pytest
import yourdfpy
from PIL import Image

from export.reading import same_robot
from robomore.envs.compile import compile_model
from robomore.errors import ExportFailed
from robomore.export.mjcf import _filled, refuse_other_model, standalone_mjcf
from robomore.export.stl import stl_bytes
from robomore.export.urdf import MESHES, roll_pitch_yaw, write_urdf
from robomore.tasks import TASKS, get_task

MACHINE = """<mujoco>
  <asset><mesh name="wedge" vertex="0 0 0 .2 0 0 0 .1 0 0 0 .1"/></asset>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="stand" pos="0 0 1" euler="0 0 30"><geom type="box" size=".1 .1 .1"/>
      <body name="arm" pos=".1 0 0" euler="20 0 0">
        <joint name="lift" type="slide" axis="0 0 1" range="-.1 .3" pos=".05 0 0" limited="true"/>
        <joint name="swing" axis="0 1 0" range="-30 60" ref="10" pos="0 0 .1" damping=".5"/>
        <geom type="cylinder" size=".03 .2" pos="0 .1 0" euler="90 0 0"/>
        <body name="no wrist"><geom type="ellipsoid" size=".05 .04 .03" mass=".1"/>
          <body name="tool" pos="0 .3 0">
            <joint name="tip" type="ball"/>
            <geom type="mesh" mesh="wedge" density="500"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor joint="swing" gear="7" ctrlrange="-2 1" ctrllimited="true"/>
    <position joint="lift" kp="10" forcerange="-5 5" forcelimited="true"/>
  </actuator>
</mujoco>"""


@pytest.mark.parametrize("task", list(TASKS))
def test_plain_mujoco_loads_the_robot_on_its_ground(task: str) -> None:
    chosen = get_task(task)
    model = compile_model(chosen, chosen.reference)
    text = standalone_mjcf(chosen, chosen.reference, model)
    again = mujoco.MjModel.from_xml_string(text)
    if not model.nhfield:
        assert text == chosen.mjcf(chosen.reference)
    for name in ("body_inertia", "body_pos", "jnt_range", "actuator_gear"):
        assert np.array_equal(getattr(model, name), getattr(again, name))
    ground = [one.hfield_data * np.float64(one.hfield_size[:, 2].sum()) for one in (model, again)]
    np.testing.assert_allclose(*ground, atol=1e-6)


def test_a_mesh_is_written_into_the_text() -> None:
    corners = np.array([[0, 0, 0], [0.2, 0, 0], [0, 0.1, 0], [0, 0, 0.3]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    text = (
        '<mujoco><compiler angle="radian"/><asset><mesh name="a" file="a.stl" scale="2 1 1"/>'
        '<texture name="t" type="2d" file="t.png"/><material name="m" texture="t"/></asset>'
        '<worldbody><body><freejoint/><geom type="mesh" mesh="a" material="m" pos="1 0 0"/></body>'
        "</worldbody></mujoco>"
    )
    assets = {"a.stl": stl_bytes(corners, faces), "t.png": _png()}
    model = mujoco.MjSpec.from_string(text, assets=assets).compile()
    filled = _filled(text, model)
    assert "file" not in filled
    refuse_other_model(filled, model)


def _png() -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (2, 2)).save(file, "PNG")
    return file.getvalue()


def test_another_model_is_refused() -> None:
    ant, powered = get_task("ant"), get_task("ant-powered")
    with pytest.raises(ExportFailed, match="actuator_gear differs"):
        refuse_other_model(powered.mjcf(ant.reference), compile_model(ant, ant.reference))
    with pytest.raises(ExportFailed, match="does not load"):
        refuse_other_model("<mujoco><limb/></mujoco>", compile_model(ant, ant.reference))


@pytest.mark.parametrize(
    "task", ["ant", "ant-powered", "hopper", "half-cheetah", "swimmer", "walker"]
)
def test_a_urdf_reader_finds_the_same_robot(task: str, tmp_path: Path) -> None:
    chosen = get_task(task)
    check(compile_model(chosen, chosen.reference), tmp_path)


def test_other_shapes_and_joints_become_urdf_too(tmp_path: Path) -> None:
    model = mujoco.MjModel.from_xml_string(MACHINE)
    robot = check(model, tmp_path)
    assert {"tip__x", "tip__y", "tip__z"} <= set(robot.joint_map)
    swing, lift = robot.joint_map["swing"], robot.joint_map["lift"]
    assert (swing.limit.effort, lift.limit.effort) == (14, 5)
    assert float(swing.dynamics.damping) == 0.5
    # Zero is the pose in which the model was written down, at 10 degrees.
    assert np.allclose(np.degrees([swing.limit.lower, swing.limit.upper]), [-40, 50])
    meshes = sorted(path.name for path in (tmp_path / MESHES).iterdir())
    assert len(meshes) == 2


def check(model: mujoco.MjModel, folder: Path) -> yourdfpy.URDF:
    """Write a robot as URDF and compare it with what a reader makes of that."""
    text, meshes = write_urdf(model, "robot")
    for name, content in meshes.items():
        (folder / MESHES).mkdir(exist_ok=True)
        (folder / MESHES / name).write_bytes(content)
    (folder / "robot.urdf").write_text(text)
    return same_robot(model, folder / "robot.urdf")


def test_angles_of_a_rotation_come_back() -> None:
    random = np.random.default_rng(1)
    for quaternion in [*random.standard_normal((20, 4)), [1, 0, 1, 0], [1, 0, -1, 0], [1, 1, 1, 1]]:
        matrix = np.empty(9)
        mujoco.mju_quat2Mat(matrix, np.array(quaternion) / np.linalg.norm(quaternion))
        roll, pitch, yaw = roll_pitch_yaw(matrix.reshape(3, 3))
        again = _about(2, yaw) @ _about(1, pitch) @ _about(0, roll)
        np.testing.assert_allclose(again, matrix.reshape(3, 3), atol=1e-7)


def _about(axis: int, angle: float) -> np.ndarray:
    turned, others = np.eye(3), np.ix_(*[[i for i in range(3) if i != axis]] * 2)
    sign = -1 if axis == 1 else 1
    sine, cosine = sign * np.sin(angle), np.cos(angle)
    turned[others] = [[cosine, -sine], [sine, cosine]]
    return turned
