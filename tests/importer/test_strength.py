"""A parameter `strength` multiplies what a robot's motors can give, whatever kind they are of."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from robomore.envs.compile import compile_model
from robomore.envs.motor_force import joint_force
from robomore.errors import InputError
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.task_file import ReadTask, read_task_file

MOTORS = {
    "gear": '<motor name="m" joint="{0}" gear="{1}" ctrlrange="-1 1"/>',
    "range": '<motor name="m" joint="{0}" ctrlrange="-{1} {1}"/>',
    "no range": '<motor name="m" joint="{0}" gear="{1}"/>',
    "limit": '<motor name="m" joint="{0}" gear="10" ctrlrange="-9 9" forcerange="-{2} {2}"/>',
    "servo": '<position name="m" joint="{0}" kp="500" ctrlrange="-1 1" forcerange="-{1} {1}"/>',
    "parent": '<motor name="m" jointinparent="{0}" gear="{1}" ctrlrange="-1 1"/>',
    "speed": '<velocity name="m" joint="{0}" kv="500" ctrlrange="-1 1" forcerange="-{1} {1}"/>',
}


def robot(torques: dict[str, float], kind: str, joint: str = "") -> str:
    """Return a robot with a leg for each joint, driven by a motor of this torque in N·m."""
    legs = "".join(
        f'<body name="{name}_leg" pos="{n} 0 0"><joint name="{name}" axis="0 1 0" range="-1 1" '
        f'limited="true" {joint}/><geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02"/></body>'
        for n, name in enumerate(torques)
    )
    motors = "".join(
        MOTORS[kind].format(name, f"{torque:g}", f"{torque / 10:g}").replace('"m"', f'"{name}_m"')
        for name, torque in torques.items()
        if torque
    )
    return (
        '<mujoco><compiler angle="radian"/><worldbody><body name="torso" pos="0 0 1"><freejoint/>'
        f'<geom size="0.1"/>{legs}</body></worldbody><actuator>{motors}</actuator></mujoco>'
    )


def task(folder: Path, text: str, *free: str, old: str = "", new: str = "") -> ReadTask:
    """Return the task that is proposed for a robot, with `old` in its file replaced by `new`."""
    (folder / "robot.xml").write_text(text)
    source = folder / "robot.xml"
    file = write_proposal(read_robot(source), source, folder / "task", free)
    written = file.read_text()
    assert old in written
    file.write_text(written.replace(old, new))
    return read_task_file(file)


def most(model: mujoco.MjModel) -> np.ndarray:
    """Return the torque (joints,) in N·m at the greatest control, in the pose 0."""
    data = mujoco.MjData(model)
    data.ctrl[:] = np.where(model.actuator_ctrllimited, model.actuator_ctrlrange[:, 1], 1.0)
    mujoco.mj_forward(model, data)
    return np.array(data.qfrc_actuator[6:])


@pytest.mark.parametrize("kind", MOTORS)
def test_a_robots_own_motors_are_what_they_are_at_the_reference(tmp_path: Path, kind: str) -> None:
    read = task(tmp_path, robot({"hip": 20.0}, kind), "hip_strength")
    assert read.task.reference == pytest.approx((20.0,))
    for torque in (10.0, 20.0, 40.0):
        model = compile_model(read.task, [torque])
        assert most(model) == pytest.approx([torque]), torque


@pytest.mark.parametrize("kind", ["gear", "servo"])
def test_the_limit_of_a_joint_grows_with_its_motors(tmp_path: Path, kind: str) -> None:
    text = robot({"hip": 20.0}, kind, 'actuatorfrcrange="-12 8"')
    read = task(tmp_path, text, "hip_strength")
    assert read.task.reference == pytest.approx((12.0,))
    for torque, forward in ((12.0, 8.0), (6.0, 4.0), (24.0, 16.0)):
        model = compile_model(read.task, [torque])
        assert most(model) == pytest.approx([forward])
        assert joint_force(model, model.joint("hip").id) == pytest.approx(torque)


def test_a_proposed_servo_is_as_strong_as_its_parameter(tmp_path: Path) -> None:
    text = robot({"hip": 0.0}, "servo", 'actuatorfrcrange="-12 12"')
    stiff = task(tmp_path, text, "hip_strength", old="stiffness = 20", new="stiffness = 900")
    for torque in (6.0, 12.0, 24.0):
        assert most(compile_model(stiff.task, [torque])) == pytest.approx([torque])


def test_unlike_motors_under_one_parameter_keep_their_proportion(tmp_path: Path) -> None:
    text = robot({"l_hip": 30.0, "r_hip": 30.0, "tail": 10.0}, "servo")
    read = task(tmp_path, text, "hip_strength", old='["l_hip", "r_hip"]', new='["*"]')
    assert most(compile_model(read.task, [30.0])) == pytest.approx([30, 30, 10])
    assert most(compile_model(read.task, [15.0])) == pytest.approx([15, 15, 5])


def test_alike_joints_of_another_strength_have_a_parameter_too(tmp_path: Path) -> None:
    text = robot({"FL_hip": 20.0, "FR_hip": 20.0, "RL_hip": 12.0, "RR_hip": 12.0}, "servo")
    edits = task(tmp_path, text, "*_strength").plan.edits
    assert {edit.parts: edit.reference for edit in edits} == {
        ("FL_hip", "FR_hip"): 20.0,
        ("RL_hip", "RR_hip"): 12.0,
    }


def test_two_parameters_for_one_joint_are_refused(tmp_path: Path) -> None:
    text = robot({"hip": 20.0, "tail": 10.0}, "servo")
    with pytest.raises(InputError, match="two parameters change the strength of `hip`"):
        task(tmp_path, text, "*_strength", old='["tail"]', new='["hip", "tail"]')
