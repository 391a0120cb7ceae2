"""What is kept of a robot's file, and what is said of the rest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dog import DOG, write_arm, write_dog
from robomore.errors import InputError
from robomore.importer.limbs import find_links, groups, kind
from robomore.importer.reading import read_robot


def test_scenery_and_what_is_only_drawn_are_left_out_and_said(tmp_path: Path) -> None:
    robot = read_robot(write_dog(tmp_path))
    model = robot.spec().compile()
    assert robot.assets == {}
    assert [model.geom(n).name for n in np.flatnonzero(model.geom_bodyid == 0)] == ["floor"]
    assert model.nmesh == 0
    assert model.body_mass.sum() == pytest.approx(5 + 4 * (0.8 + 0.2))
    said = " ".join(robot.notes)
    assert "`wall`" in said and "4 geoms that are only drawn" in said


def test_a_keyframe_is_the_home_pose_and_a_second_body_is_left_out(tmp_path: Path) -> None:
    bent = " ".join(["0.8 -1.6"] * 4)
    key = f'<keyframe><key name="home" qpos="0 0 0.3 1 0 0 0 {bent}"/></keyframe></mujoco>'
    ball = '<body name="ball" pos="2 0 1"><geom size="0.1"/></body></worldbody>'
    robot = read_robot(write_dog(tmp_path, DOG.replace("</mujoco>", key)))
    assert robot.home["FL_hip"] == 0.8 and robot.home["RR_knee"] == -1.6
    robot = read_robot(write_dog(tmp_path, DOG.replace("</worldbody>", ball)))
    assert "`ball` stands beside the robot" in robot.notes[0]


def test_an_include_is_read(tmp_path: Path) -> None:
    (tmp_path / "sensors.xml").write_text(
        "<mujocoinclude><sensor><gyro name='g' site='imu'/></sensor></mujocoinclude>"
    )
    text = DOG.replace("<actuator>", '<include file="sensors.xml"/><actuator>')
    assert "include" not in read_robot(write_dog(tmp_path, text)).xml


def test_the_base_of_a_urdf_is_free_and_not_welded_to_the_world(tmp_path: Path) -> None:
    free = read_robot(write_arm(tmp_path))
    model = free.spec().compile()
    assert model.nv == 7 and model.body_mass.sum() == pytest.approx(3.2)
    assert "it has a free joint now" in free.notes[0]
    fixed = read_robot(write_arm(tmp_path), "fixed")
    assert fixed.spec().compile().nv == 1
    assert set(fixed.assets) == {"shell.obj"}, "a mesh of a package:// address travels as content"


def test_a_file_that_is_no_robot_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"is no robot that MuJoCo reads: .*no body"):
        read_robot(write_dog(tmp_path, "<mujoco><worldbody/></mujoco>"))
    with pytest.raises(InputError, match=r"there is no file .*nothing\.xml"):
        read_robot(tmp_path / "nothing.xml")
    (tmp_path / "shell.obj").unlink(missing_ok=True)
    text = DOG.replace('contype="0" conaffinity="0" group="2"', "")
    (tmp_path / "dog.xml").write_text(text)
    with pytest.raises(InputError, match=r"shell\.obj"):
        read_robot(tmp_path / "dog.xml")


def test_repeated_legs_form_groups(tmp_path: Path) -> None:
    model = read_robot(write_dog(tmp_path)).spec().compile()
    found = dict(groups(find_links(model), model))
    assert {name: len(group) for name, group in found.items()} == {"thigh": 4, "calf": 4}
    thigh, calf = found["thigh"][0], found["calf"][0]
    assert (thigh.length, thigh.radius) == pytest.approx((0.2, 0.02))
    assert (calf.length, calf.leaf, calf.axis) == (pytest.approx(0.2), True, (0.0, 0.0, -1.0))


@pytest.mark.parametrize(
    ("name", "what"),
    [("FL_thigh", "thigh"), ("thigh_back_right", "thigh"), ("leftKneeLink", "knee"), ("l1", "l1")],
)
def test_a_kind_is_a_name_without_its_side(name: str, what: str) -> None:
    assert kind(name) == what


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"FL_calf"', '"{leg}"', r"a <body> has name='{leg}'; braces stand for numbers"),
        ('"FL_upper"', '"{__import__}"', r"dog.xml: a <geom> has name='{__import__}'"),
        ('"RR_knee"', '"knee}"', r"='knee}'; .* without braces wherever the file has it"),
        ('model="dog"', 'model="{1 + 1}"', r"a <mujoco> has model='{1 \+ 1}'"),
    ],
)
def test_names_that_would_be_placeholders_are_refused(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    assert old in DOG
    with pytest.raises(InputError, match=said):
        read_robot(write_dog(tmp_path, DOG.replace(old, new)))
