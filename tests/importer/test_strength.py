"""A parameter `strength` multiplies what a robot's motors can give, whatever kind they are of."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from robomore.envs.compile import compile_model
from robomore.envs.motor_force import joint_force
from robomore.errors import InputError
from robomore.importer.edits import Edit, MotorGroup
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import Robot, read_robot
from robomore.importer.strength import strength_of
from robomore.importer.task_file import ReadTask, read_task_file
from robomore.importer.template import TemplateWriter
from robomore.tasks.template import fill

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


def test_alike_joints_of_another_strength_share_a_parameter(tmp_path: Path) -> None:
    text = robot({"FL_hip": 20.0, "FR_hip": 20.0, "RL_hip": 12.0, "RR_hip": 12.0}, "servo")
    (edit,) = task(tmp_path, text, "*_strength").plan.edits
    assert (edit.parts, edit.reference) == (("FL_hip", "FR_hip", "RL_hip", "RR_hip"), 20.0)


def test_two_parameters_for_one_joint_are_refused(tmp_path: Path) -> None:
    text = robot({"hip": 20.0, "tail": 10.0}, "servo")
    with pytest.raises(InputError, match="two parameters change the strength of `hip`"):
        task(tmp_path, text, "*_strength", old='["tail"]', new='["hip", "tail"]')


LEG = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="upper" pos="0 0 1">
      <joint name="hip" axis="0 1 0" range="-1 1" limited="true"/>
      <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02"/>
      <body name="lower" pos="0.3 0 0">
        <joint name="knee" axis="0 1 0" range="-1 1" limited="true" {joint}/>
        <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02"/>
      </body>
    </body>
  </worldbody>
  <actuator>{motors}</actuator>
</mujoco>
"""


def leg(folder: Path, motors: str, joint: str = "") -> Robot:
    (folder / "leg.xml").write_text(LEG.format(motors=motors, joint=joint))
    return read_robot(folder / "leg.xml", "fixed")


def built(robot: Robot, *edits: Edit, **values: float) -> mujoco.MjModel:
    text = fill(TemplateWriter(robot, edits).text(), values)
    return mujoco.MjSpec.from_string(text, assets=robot.assets).compile()


OWN = (
    ('<motor joint="hip" ctrlrange="-20 20"/>', '<motor joint="knee" ctrlrange="-12 12"/>', ""),
    (
        '<motor joint="hip" gear="20" ctrlrange="-1 1"/>',
        '<motor joint="knee" gear="12" ctrlrange="-1 1"/>',
        "",
    ),
    (
        '<position joint="hip" kp="90" forcerange="-20 20" ctrlrange="-1 1"/>',
        '<position joint="knee" kp="90" gear="2" forcerange="-6 6" ctrlrange="-1 1"/>',
        "",
    ),
    (
        '<general joint="hip" gear="10" ctrlrange="-9 9" forcerange="-2 2"/>',
        '<motor joint="knee" ctrlrange="-50 50"/>',
        'actuatorfrcrange="-12 12"',
    ),
)


@pytest.mark.parametrize(("hip", "knee", "joint"), OWN)
def test_the_strength_of_own_motors_is_scaled_and_each_keeps_its_share(
    hip: str, knee: str, joint: str, tmp_path: Path
) -> None:
    robot = leg(tmp_path, hip + knee, joint)
    before = robot.spec().compile()
    assert [strength_of(before, (), name) for name in ("hip", "knee")] == pytest.approx([20, 12])
    both = Edit("strength", "strength", ("hip", "knee"), 20.0)
    for factor in (0.5, 1.0, 2.0):
        model = built(robot, both, strength=20.0 * factor)
        told = [joint_force(model, number) for number in range(2)]
        assert told == pytest.approx([20 * factor, 12 * factor])
    one = built(robot, Edit("strength", "strength", ("hip",), 20.0), strength=40.0)
    assert [joint_force(one, number) for number in range(2)] == pytest.approx([40, 12])


@pytest.mark.parametrize("kind", ["motor", "servo"])
def test_the_strength_of_added_motors_is_the_parameter(kind: str, tmp_path: Path) -> None:
    robot = leg(tmp_path, "")
    groups = (MotorGroup(("hip", "knee"), kind, 8.0, 50.0, 1.0),)  # type: ignore[arg-type]
    edit = Edit("strength", "strength", ("knee",), 8.0)
    text = fill(TemplateWriter(robot, (edit,), groups).text(), {"strength": 4.0})
    model = mujoco.MjSpec.from_string(text, assets=robot.assets).compile()
    assert [joint_force(model, number) for number in range(2)] == pytest.approx([8, 4])
