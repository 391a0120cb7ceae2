"""What is said of how a task was understood: its rest pose, control rate, radii and followers."""

from __future__ import annotations

from pathlib import Path

import pytest

from robomore.envs.vector_env import VectorEnv
from robomore.errors import InputError
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.task_file import ReadTask, read_task_file
from robomore.importer.template import TemplateWriter
from robomore.search.slim_reference import thinnest
from robomore.tasks.portable import task_content, task_from_content
from robomore.tasks.unit_space import UnitSpace

LEG = """<mujoco><compiler angle="radian"/><option timestep="0.008"/><worldbody>
<body name="torso" pos="0 0 1"><freejoint/><geom size="0.1"/>
<body name="thigh"><joint name="hip" axis="0 1 0" range="-1 1"/>
<geom type="cylinder" fromto="0 0 0 0 0 -0.3" size="0.02"/>
<body name="shin" pos="0 0 -0.3"><joint name="knee" axis="0 1 0" range="-1 1" ref="0.5"/>
<geom type="box" pos="0 0 -0.2" size="0.02 0.02 0.2"/></body></body></body></worldbody>
<actuator><motor joint="hip" gear="20" ctrlrange="-1 1"/></actuator>{}</mujoco>"""

GRIPPER = """<robot name="gripper"><link name="hand">{0}</link><link name="left">{0}</link>
<link name="right">{0}</link>
<joint name="l" type="revolute"><parent link="hand"/><child link="left"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="12" velocity="3"/></joint>
<joint name="r" type="revolute"><parent link="hand"/><child link="right"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="8" velocity="3"/><mimic joint="l" multiplier="-1"/></joint>
</robot>""".format(
    '<inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/>'
    '</inertial><collision><origin xyz="0 0 -.1"/><geometry><cylinder length=".2" radius=".02"/>'
    "</geometry></collision>"
)


def task(source: Path, text: str, *free: str, old: str = "", new: str = "") -> ReadTask:
    """Return the task that is proposed for a robot, with `old` in its file replaced by `new`."""
    source.write_text(text)
    file = write_proposal(read_robot(source), source, source.parent / "task", free)
    written = file.read_text()
    assert old in written
    file.write_text(written.replace(old, new, 1))
    return read_task_file(file)


@pytest.mark.parametrize(
    ("key", "stated", "knee"),
    [
        ("", "", 0.5),
        ("", "[home.joints]\nknee = 0.0\n", 0.0),
        ("", "[home.joints]\nknee = 0.2\n", 0.2),
        ('<keyframe><key qpos="0 0 1 1 0 0 0 0 0"/></keyframe>', "", 0.0),
        ('<keyframe><key qpos="0 0 1 1 0 0 0 0 0.5"/></keyframe>', "", 0.5),
    ],
)
def test_a_joint_rests_where_it_is_said_to_and_else_at_its_ref(
    tmp_path: Path, key: str, stated: str, knee: float
) -> None:
    text = LEG.format(key)
    read = task(tmp_path / "leg.xml", text, old="[health]", new=f"{stated}[health]")
    env = VectorEnv(read.task, read.task.reference, 1)
    assert env.environment.init_qpos[-1] == pytest.approx(knee)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("asked", "said"), [("50", "control_hz = 50 is no whole number"), ("62.5", ""), ("125", "")]
)
def test_a_control_rate_that_cannot_be_is_told(tmp_path: Path, asked: str, said: str) -> None:
    change = {"old": "control_hz = 50", "new": f"control_hz = {asked}"}
    read = task(tmp_path / "leg.xml", LEG.format(""), **change)
    told = [note for note in read.notes if note.startswith("control_hz")]
    assert [note[: len(said)] for note in told] == ([said] if said else [])


def test_a_joint_that_mimics_another_has_no_motor_and_is_told(tmp_path: Path) -> None:
    read = task(tmp_path / "gripper.urdf", GRIPPER)
    assert [group.joints for group in read.plan.motors] == [("l",)]
    assert "the joint `r` follows `l`, and it has no motor" in read.notes
    both = task(tmp_path / "gripper.urdf", GRIPPER, old='joints = ["l"]', new='joints = ["l", "r"]')
    assert "the joint `r` follows `l`, and its own motor works against that" in both.notes


def test_lengths_of_solids_without_a_radius_are_no_radii(tmp_path: Path) -> None:
    read = task(tmp_path / "leg.xml", LEG.format(""), "*_length", "*_radius")
    names = ("thigh_length", "shin_length", "thigh_radius", "shin_radius")
    assert read.task.names == names
    for one in (read.task, task_from_content(task_content(read.task))):
        assert UnitSpace(one).radii.tolist() == [False, False, True, True]
        slimmed = dict(zip(names, thinnest(one).parameters, strict=True))
        assert slimmed["thigh_length"] == pytest.approx(0.3)
        assert slimmed["thigh_radius"] == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ('size="0.1"', 'size="0.2"', "reaches 0.2 m from its middle and not 0.1 m"),
        ('density="1000"', 'density="1200"', "it weighs .* kg and not .* kg"),
    ],
)
def test_a_template_that_makes_another_robot_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, old: str, new: str, fault: str
) -> None:
    source = tmp_path / "leg.xml"
    source.write_text(LEG.format(""))
    file = write_proposal(read_robot(source), source, tmp_path / "task", ())
    right = TemplateWriter.text
    assert old in right(TemplateWriter(read_robot(source), ()))

    def wrong(writer: TemplateWriter) -> str:
        # The same weight, where it is the size that differs.
        return right(writer).replace(old, new + (' mass="4.18879"' if "size" in new else ""))

    monkeypatch.setattr(TemplateWriter, "text", wrong)
    with pytest.raises(InputError, match=fault):
        read_task_file(file)
