"""Robots that are written in unusual ways, and what is kept or said of them."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from dog import ARM, SHELL
from robomore.envs.measured_env import MeasuredEnv
from robomore.envs.rest_pose import starting_pose
from robomore.errors import InputError
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import Robot, read_robot
from robomore.importer.task_file import ReadTask, read_task_file
from robomore.testing.tasks import check_task
from tripod import STEADY

HALF = 0.5**0.5

TWO_LINKS = """<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="mount" pos="0 0 {height}">
      <geom type="box" size="0.05 0.05 0.02"/>
      <body name="upper" pos="0 0 -0.03">
        <joint name="shoulder" axis="0 1 0" range="-3 3" armature="0.02" damping="0.2"/>
        <geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.3"/>
      </body>
    </body>
  </worldbody>
  <actuator><position joint="shoulder" kp="50" kv="2" ctrlrange="-3 3"/></actuator>
</mujoco>
"""

PLANAR = STEADY.replace(
    "<freejoint/>",
    '<joint name="up" type="slide" axis="0 0 1" damping="0" armature="0"/>'
    '<joint name="along" type="slide" axis="1 0 0" damping="0" armature="0"/>'
    '<joint name="lean" axis="0 1 0" damping="0" armature="0"/>',
)


def read(folder: Path, text: str, name: str = "odd.xml") -> Robot:
    (folder / name).write_text(text, encoding="utf-8")
    return read_robot(folder / name)


def proposed(folder: Path, text: str, name: str = "odd.xml") -> ReadTask:
    robot = read(folder, text, name)
    return read_task_file(write_proposal(robot, folder / name, folder / "out"))


def lowest(made: ReadTask, scale: float) -> float:
    """Return the distance in m between the floor and the robot at rest, its links scaled."""
    spec = mujoco.MjSpec.from_string(
        made.task.mjcf([scale * one.reference for one in made.task.parameters])
    )
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = starting_pose(made.task, model)
    mujoco.mj_kinematics(model, data)
    floor = model.geom("floor").id
    robot = np.flatnonzero(model.geom_bodyid > 0)
    return min(mujoco.mj_geomDistance(model, data, floor, int(one), 9.0, None) for one in robot)


def ends(made: ReadTask, qpos: dict[int, float] | None = None) -> tuple[str, float]:
    """Return why an episode without actions ends, and what it is worth; first put it somewhere."""
    env = MeasuredEnv(made.task, made.task.reference, 1)
    env.reset_one(0, 0)
    for place, value in (qpos or {}).items():
        env.data[0].qpos[place] = value
    while not env.motions:
        env.step(np.zeros((1, env.action_size)))
    return env.motions[0].fall, env.motions[0].fitness


@pytest.mark.parametrize(
    ("turn", "key"),
    [
        (f'quat="{HALF} {HALF} 0 0"', ""),
        ("", f'<keyframe><key qpos="0 0 1 {HALF} {HALF} 0 0 0 -1 0 -1 0 -1"/></keyframe>'),
    ],
)
def test_the_root_lies_as_the_file_says(tmp_path: Path, turn: str, key: str) -> None:
    text = STEADY.replace('name="trunk" pos', f'name="trunk" {turn} pos')
    made = proposed(tmp_path, text.replace("</mujoco>", f"{key}</mujoco>"))
    assert made.plan.upright == pytest.approx((HALF, HALF, 0, 0))
    file = tmp_path / "out" / "task.toml"
    file.write_text(
        file.read_text()
        .replace('"distance"', '"time-upright"')
        .replace("episode_seconds = 20", "episode_seconds = 0.2")
    )
    assert ends(read_task_file(file)) == ("", pytest.approx(0.2))


def test_a_rotation_has_the_length_1(tmp_path: Path) -> None:
    proposed(tmp_path, STEADY)
    file = tmp_path / "out" / "task.toml"
    text = file.read_text().replace(
        "[home.joints]", "[home]\nupright = [1, 1, 0, 0]\n[home.joints]"
    )
    file.write_text(text)
    assert read_task_file(file).plan.upright == pytest.approx((HALF, HALF, 0, 0))


@pytest.mark.parametrize("first", [True, False])
def test_a_keyframe_of_a_scene_is_read_for_the_robot(tmp_path: Path, first: bool) -> None:
    cube, pose = '<body name="cube"><freejoint/><geom size="0.05"/></body>', "0.3 -1 " * 3
    robot, there = f"0 0 1 1 0 0 0 {pose}", "1 0 0 1 0 0 0"
    world = "<worldbody>" if first else "</worldbody>"
    text = STEADY.replace(world, world + cube if first else cube + world)
    qpos = f"{there} {robot}" if first else f"{robot} {there}"
    key = f'<keyframe><key qpos="{qpos}"/></keyframe></mujoco>'
    home = read(tmp_path, text.replace("</mujoco>", key)).home
    assert (home["L_hip"], home["B_knee"]) == (0.3, -1.0)
    short = f'<keyframe><key name="short" qpos="{pose}"/></keyframe></mujoco>'
    with pytest.raises(InputError, match=r"short"):
        read(tmp_path, text.replace("</mujoco>", short))


def test_the_ground_touches_as_in_the_file_and_tilts_are_told(tmp_path: Path) -> None:
    ice = '<worldbody><geom name="ice" type="plane" size="5 5 1" friction="0.1" condim="1" {}/>'
    pair = '<contact><pair geom1="ice" geom2="{}"/></contact></mujoco>'.format("L_shin")
    named = STEADY.replace("</mujoco>", pair).replace("<geom type", '<geom name="{}" type')
    parts = ("trunk", *(f"{leg}_{link}" for leg in "LRB" for link in ("thigh", "shin")))
    text = named.format(*parts).replace("<worldbody>", ice.format('euler="0 0.2 0"'))
    assert "the ground `ice` is level here" in " ".join(read(tmp_path, text).notes)
    made = proposed(tmp_path, text)
    model = mujoco.MjSpec.from_string(made.task.mjcf(made.task.reference)).compile()
    floor = model.geom("floor")
    assert (floor.friction[0], floor.condim[0], floor.quat[0]) == (0.1, 1, 1)
    assert model.npair == 1 and floor.id in (model.pair_geom1[0], model.pair_geom2[0])


def test_what_a_tendon_goes_around_is_kept(tmp_path: Path) -> None:
    around = (
        '<site name="a" pos="0.1 0 0.1"/><site name="b" pos="-0.1 0 0.1"/>'
        '<geom name="drum" size="0.02" mass="0" contype="0" conaffinity="0" pos="0 0 0.1"/>'
    )
    tendon = (
        '<tendon><spatial><site site="a"/><geom geom="drum"/><site site="b"/></spatial></tendon>'
    )
    text = STEADY.replace("<freejoint/>", "<freejoint/>" + around)
    robot = read(tmp_path, text.replace("</mujoco>", f"{tendon}</mujoco>"))
    assert robot.spec().compile().ntendon == 1


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('<geom type="box"', '<geom name="floor" type="box"', "'floor', as the ground is; rename"),
        (
            "</mujoco>",
            '<sensor><clock name="contact_L_shin"/></sensor></mujoco>',
            "_shin' in <sens",
        ),
        (
            "<compiler",
            '<default><geom contype="0" conaffinity="0"/></default><compiler',
            "falls thr",
        ),
        ("0 0 0 0 0 -0.2", "0 0 0 0 0 -200", r"`\w+` reaches 100 m from .* in mm by 1000"),
    ],
)
def test_a_robot_that_cannot_be_is_refused(tmp_path: Path, old: str, new: str, said: str) -> None:
    assert old in STEADY
    with pytest.raises(InputError, match=said):
        proposed(tmp_path, STEADY.replace(old, new))


def test_a_urdf_is_one_whatever_it_is_called_and_needs_solids(tmp_path: Path) -> None:
    (tmp_path / "shell.obj").write_text(SHELL)
    for name in ("arm.xml", "arm.URDF"):
        assert read(tmp_path, f"<!-- <mujoco> -->{ARM}", name).spec().compile().nv == 7
    drawn = ARM.replace("collision>", "visual>")
    with pytest.raises(InputError, match=r"no solid: .*<collision>"):
        read(tmp_path, drawn, "arm.urdf")


def test_a_footprint_is_no_root(tmp_path: Path) -> None:
    (tmp_path / "shell.obj").write_text(SHELL)
    foot = (
        '<link name="base_footprint"/><joint name="up" type="fixed">'
        '<parent link="base_footprint"/><child link="base"/><origin xyz="0 0 0.05"/></joint>'
    )
    text = ARM.replace("</robot>", f"{foot}</robot>")
    assert proposed(tmp_path, text, "arm.urdf").robot.spec().bodies[1].name == "base"


def test_a_root_on_the_floor_has_no_height_to_go_by(tmp_path: Path) -> None:
    text = STEADY.replace('name="trunk" pos="0 0 0.4"', 'name="sole" pos="0 0 0"')
    inner = '<freejoint/><body name="trunk" pos="0 0 0.41"><geom size="0.01"/>'
    text = text.replace("<freejoint/>", inner).replace("</worldbody>", "</body></worldbody>")
    made = proposed(tmp_path, text)
    assert made.plan.healthy_height is None
    check_task(made.task)
    file = tmp_path / "out" / "task.toml"
    file.write_text(file.read_text().replace("[health]", "[health]\nheight = [0.5, 2.0]"))
    with pytest.raises(InputError, match=r"the root `sole` rests on .*leave that line out"):
        read_task_file(file)


@pytest.mark.parametrize("name", ["Hüfte", "arm[0]", "arm\\x", "a.b"])
def test_any_name_is_written_and_read_back(tmp_path: Path, name: str) -> None:
    text = STEADY.replace("L_shin", name).replace("L_knee", name)
    made = proposed(tmp_path, text)
    assert any(name in edit.parts for edit in made.plan.edits)
    assert made.plan.home[name] == pytest.approx(-1.3)


def test_a_pose_that_is_rounded_stays_in_its_range(tmp_path: Path) -> None:
    text = STEADY.replace("-2.2 -0.4", "0.8203 0.8206").replace("-1 1", "0.8203 0.8206")
    made = proposed(tmp_path, text)
    assert all(0.8203 <= angle <= 0.8206 for angle in made.plan.home.values())


def test_a_robot_in_a_plane_stands_on_the_floor_and_gets_somewhere(tmp_path: Path) -> None:
    made = proposed(tmp_path, PLANAR)
    assert made.task.goal.name == "distance" and "heading" not in made.task.reward
    assert "in the plane of x and z, with 6 joints" in made.task.description
    for scale in (1.0, 1.6):
        assert lowest(made, scale) == pytest.approx(0.003, abs=1e-6)
    check_task(made.task)
    file = tmp_path / "out" / "task.toml"
    file.write_text(file.read_text().replace("episode_seconds = 20", "episode_seconds = 0.1"))
    assert ends(read_task_file(file), {1: 2.0})[1] == pytest.approx(2.0, abs=0.1)
    assert ends(made, {0: 9.0})[0] == "too_high"
    assert ends(made, {2: 1.5})[0] == "tilted"
    with pytest.raises(InputError, match=r"hangs from the world by joints \(`up`, `along`, `lean`"):
        read_robot(tmp_path / "odd.xml", "free")


def test_no_motor_is_proposed_for_a_root_in_a_plane_and_a_keyframe_leans_it(tmp_path: Path) -> None:
    key = '<keyframe><key qpos="5 6 0.1 0 -1 0 -1 0 -1"/></keyframe></mujoco>'
    bare = PLANAR.partition("<actuator>")[0] + key
    made = proposed(tmp_path, bare)
    driven = {joint for group in made.plan.motors for joint in group.joints}
    assert driven == {f"{leg}_{joint}" for leg in "LRB" for joint in ("hip", "knee")}
    assert made.plan.home["lean"] == 0.1 and "along" not in made.plan.home
    assert lowest(made, 1.0) == pytest.approx(0.003, abs=1e-6)


def test_a_free_robot_that_tilts_is_told_as_tilted(tmp_path: Path) -> None:
    made = proposed(tmp_path, STEADY)
    assert ends(made, {3: HALF, 4: HALF})[0] == "tilted"


def test_what_hangs_into_the_floor_does_not_touch_it_and_is_told(tmp_path: Path) -> None:
    low = proposed(tmp_path, TWO_LINKS.format(height=0.2))
    assert "`upper` is 0.15 m inside the floor at rest" in " ".join(low.notes)
    assert '<exclude body1="world" body2="upper"' in low.task.template
    high = proposed(tmp_path, TWO_LINKS.format(height=0.5))
    assert "inside the floor" not in " ".join(high.notes)
