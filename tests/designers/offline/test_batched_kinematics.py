from __future__ import annotations

import mujoco
import numpy as np
import pytest

from robomore.designers.offline.batched_kinematics import BatchedKinematics
from robomore.designers.offline.robot_semantics import robot_semantics
from robomore.tasks.registry import PAPER_TASKS, TASKS
from robomore.tasks.task import Task

NO_TERRAIN = [task for task in PAPER_TASKS if task.terrain is None]


def compiled(task: Task) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_string(task.mjcf(task.reference))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


@pytest.mark.parametrize("task", NO_TERRAIN, ids=lambda task: task.id)
def test_limbs_are_where_mujoco_puts_them(task: Task) -> None:
    model, data = compiled(task)
    columns = {name: np.array([value]) for name, value in task.named(task.reference).items()}
    pose = BatchedKinematics(task.template, task.constants).rest_pose(columns)
    solid = model.geom_bodyid > 0
    # The same order is not promised, so both are sorted.
    ours = np.column_stack((pose.ends[0].mean(axis=1), pose.radii[0]))
    theirs = np.column_stack((data.geom_xpos[solid], model.geom_size[solid, 0]))
    np.testing.assert_allclose(
        np.sort(ours.round(6), axis=0), np.sort(theirs.round(6), axis=0), atol=2e-6
    )


@pytest.mark.parametrize("task", NO_TERRAIN, ids=lambda task: task.id)
def test_joints_are_read_where_mujoco_keeps_them(task: Task) -> None:
    model, _ = compiled(task)
    joints = model.actuator_trnid[:, 0]
    read = robot_semantics(task).expressions
    names = {"self": type("", (), {"data": type("", (), {})()})()}
    names["self"].data.qpos = np.arange(model.nq)
    names["self"].data.qvel = np.arange(model.nv)
    assert eval(read["angles"], names).tolist() == model.jnt_qposadr[joints].tolist()
    assert eval(read["rates"], names).tolist() == model.jnt_dofadr[joints].tolist()


STAND = """<mujoco><worldbody><body name="torso" pos="0 0 1">
  <geom type="capsule" fromto="-0.5 0 0 0.5 0 0" size="0.05"/>
  <body name="leg" pos="{place} 0 0"><joint axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 0 0 {-length}" size="0.02"/></body>
  <body name="other" pos="0.1 0 0"><joint axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 0 0 -1" size="0.02"/></body>
</body></worldbody></mujoco>"""


def test_a_rest_pose_tells_standing_from_falling_over() -> None:
    rows = {"place": np.array([-0.3, 0.4, -0.3]), "length": np.array([1.0, 1.0, 0.5])}
    pose = BatchedKinematics(STAND, {}).rest_pose(rows)
    assert pose.overhang[0] == 0 and pose.tilt[0] == 0  # one leg behind the centre, one before it
    assert pose.overhang[1] > 0.03  # both legs before it
    assert pose.tilt[2] == pytest.approx(0.5)  # one leg half as long
    assert pose.folding.tolist() == pytest.approx([1, 1, 1])


def test_a_leg_along_its_hinge_has_no_leverage() -> None:
    ant = TASKS["ant"]
    named = ant.named(ant.reference)
    across, along = dict(named), dict(named)
    # The ankles turn about the diagonals that are square to the official legs.
    across["foot_x"] = across["foot_y"] = 0.4
    along["foot_x"], along["foot_y"] = 0.01, 0.6
    rows = {name: np.array([across[name], along[name]]) for name in named}
    pose = BatchedKinematics(ant.template, ant.constants).rest_pose(rows)
    assert pose.leverage[0] == pytest.approx(1)
    assert pose.leverage[1] < 0.9


def test_rotated_bodies_are_refused() -> None:
    text = '<mujoco><worldbody><body quat="1 0 0 0"><geom size="1"/></body></worldbody></mujoco>'
    with pytest.raises(ValueError, match="rotated by quat"):
        BatchedKinematics(text, {})
