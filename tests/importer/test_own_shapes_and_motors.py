"""Meshes that lie along any axis of their file, and motors that a robot brings with it."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from robomore.envs.motor_force import joint_force
from robomore.errors import InputError
from robomore.importer.edits import Edit, MotorGroup
from robomore.importer.reading import Robot, read_robot
from robomore.importer.strength import strength_of
from robomore.importer.template import TemplateWriter
from robomore.tasks.template import fill

LEG = """
<mujoco>
  <compiler angle="radian"/>
  <asset><mesh name="bar" file="bar.obj"/></asset>
  <worldbody>
    <body name="upper" pos="0 0 1">
      <joint name="hip" axis="0 1 0" range="-1 1" limited="true"/>
      <geom type="mesh" mesh="bar"/>
      <body name="lower" pos="0.3 0 0">
        <joint name="knee" axis="0 1 0" range="-1 1" limited="true" {joint}/>
        <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02"/>
      </body>
    </body>
  </worldbody>
  <actuator>{motors}</actuator>
</mujoco>
"""


def bar(path: Path) -> None:
    """Write a box of 0.3 m along x, 0.06 m along y and 0.04 m along z that begins at the origin."""
    corners = [(x, y, z) for x in (0, 0.3) for y in (-0.03, 0.03) for z in (-0.02, 0.02)]
    faces = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    text = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {face}" for face in faces]
    path.write_text("\n".join(text))


def leg(folder: Path, motors: str, joint: str = "") -> Robot:
    bar(folder / "bar.obj")
    (folder / "leg.xml").write_text(LEG.format(motors=motors, joint=joint))
    return read_robot(folder / "leg.xml", "fixed")


def built(robot: Robot, *edits: Edit, **values: float) -> mujoco.MjModel:
    text = fill(TemplateWriter(robot, edits).text(), values)
    return mujoco.MjSpec.from_string(text, assets=robot.assets).compile()


def extent(model: mujoco.MjModel) -> np.ndarray:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    geom = next(g for g in range(model.ngeom) if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_MESH)
    mesh = model.geom_dataid[geom]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    points = model.mesh_vert[first : first + count] @ data.geom_xmat[geom].reshape(3, 3).T
    return np.ptp(points, axis=0)


MOTORS = '<motor joint="hip" ctrlrange="-1 1"/><motor joint="knee" ctrlrange="-1 1"/>'


def test_a_mesh_grows_along_the_link_whatever_its_axis_of_inertia(tmp_path: Path) -> None:
    robot = leg(tmp_path, MOTORS)
    length = Edit("size", "length", ("upper",), 0.3)
    radius = Edit("size", "radius", ("upper",), 0.02)
    assert extent(built(robot, length, size=0.3)) == pytest.approx((0.3, 0.06, 0.04), abs=1e-4)
    longer = built(robot, length, size=0.6)
    assert extent(longer) == pytest.approx((0.6, 0.06, 0.04), abs=1e-4)
    assert longer.body("lower").pos == pytest.approx((0.6, 0, 0))
    thicker = built(robot, radius, size=0.04)
    assert extent(thicker) == pytest.approx((0.3, 0.12, 0.08), abs=1e-4)


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


def test_a_joint_gives_no_more_than_its_motors_can(tmp_path: Path) -> None:
    motors = '<motor joint="hip" ctrlrange="-1 1"/><motor joint="knee" ctrlrange="-6 6"/>'
    robot = leg(tmp_path, motors, 'actuatorfrcrange="-12 12"')
    assert joint_force(robot.spec().compile(), 1) == 6.0


@pytest.mark.parametrize("kind", ["motor", "servo"])
def test_the_strength_of_added_motors_is_the_parameter(kind: str, tmp_path: Path) -> None:
    robot = leg(tmp_path, "")
    groups = (MotorGroup(("hip", "knee"), kind, 8.0, 50.0, 1.0),)  # type: ignore[arg-type]
    edit = Edit("strength", "strength", ("knee",), 8.0)
    text = fill(TemplateWriter(robot, (edit,), groups).text(), {"strength": 4.0})
    model = mujoco.MjSpec.from_string(text, assets=robot.assets).compile()
    assert [joint_force(model, number) for number in range(2)] == pytest.approx([8, 4])


def test_two_parameters_for_one_motor_are_refused(tmp_path: Path) -> None:
    robot = leg(tmp_path, MOTORS)
    edits = (Edit("a", "strength", ("hip",), 1.0), Edit("b", "strength", ("hip", "knee"), 1.0))
    with pytest.raises(InputError, match="two parameters change the strength of `hip`"):
        TemplateWriter(robot, edits)


FRAMED = """
<mujoco>
  <default><default class="soft"><joint damping="2" armature="0.01"/></default></default>
  <worldbody>
    <body name="upper" pos="0 0 1">
      <frame childclass="soft" pos="0 0 0.1">
        <joint name="hip" axis="0 1 0" range="-1 1" limited="true"/>
        <frame><geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02"/></frame>
        <body name="lower" pos="0.3 0 0">
          <joint name="knee" axis="0 1 0" range="-1 1" limited="true"/>
          <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02"/>
        </body>
      </frame>
    </body>
  </worldbody>
  <actuator><motor joint="hip" ctrlrange="-1 1"/></actuator>
</mujoco>
"""


def test_the_class_of_a_frame_stays_with_what_stands_in_it(tmp_path: Path) -> None:
    (tmp_path / "framed.xml").write_text(FRAMED)
    robot = read_robot(tmp_path / "framed.xml", "fixed")
    model = built(robot, Edit("size", "length", ("lower",), 0.2), size=0.2)
    assert model.dof_damping == pytest.approx([2, 2])
    assert model.dof_armature == pytest.approx([0.01, 0.01])
