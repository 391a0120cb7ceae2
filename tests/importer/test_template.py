"""A stretched robot: what grows, what moves, and what it weighs."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from dog import write_arm, write_dog
from robomore.envs.compile import model_volume
from robomore.importer.amounts import Amount, texts
from robomore.importer.edits import MASS_MODES, Edit, MassMode
from robomore.importer.limbs import find_links
from robomore.importer.reading import Robot, read_robot
from robomore.importer.template import TemplateWriter
from robomore.tasks.solids import solids
from robomore.tasks.template import fill

LEGS = ("FL", "FR", "RL", "RR")
EDITS = (
    Edit("thigh_length", "length", tuple(f"{leg}_thigh" for leg in LEGS), 0.2),
    Edit("thigh_radius", "radius", tuple(f"{leg}_thigh" for leg in LEGS), 0.02),
    Edit("hip_strength", "strength", tuple(f"{leg}_hip" for leg in LEGS), 20.0),
)
REFERENCE = {edit.name: edit.reference for edit in EDITS}


@pytest.fixture
def dog(tmp_path: Path) -> Robot:
    return read_robot(write_dog(tmp_path))


def compiled(robot: Robot, mode: MassMode, **changed: float) -> mujoco.MjModel:
    text = TemplateWriter(robot, EDITS, (), mode).text()
    return mujoco.MjSpec.from_string(fill(text, REFERENCE | changed)).compile()


def inertia(model: mujoco.MjModel) -> np.ndarray:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return np.array(data.M)


@pytest.mark.parametrize("mode", ["length", "shell"])
def test_the_reference_parameters_leave_the_robot_as_it_is(dog: Robot, mode: MassMode) -> None:
    before, after = dog.spec().compile(), compiled(dog, mode)
    np.testing.assert_allclose(inertia(after), inertia(before), atol=1e-6)
    assert after.body("FL_calf").pos == pytest.approx(before.body("FL_calf").pos)


def test_density_gives_each_link_its_stated_mass(dog: Robot) -> None:
    before, after = dog.spec().compile(), compiled(dog, "density")
    assert after.body("FL_thigh").mass == pytest.approx(before.body("FL_thigh").mass)
    assert compiled(dog, "density", thigh_radius=0.04).body("FL_thigh").mass > 3 * 0.8


def test_mass_follows_length_and_thickness_as_the_mode_says(dog: Robot) -> None:
    def thigh(mode: MassMode, **changed: float) -> float:
        model = compiled(dog, mode, **changed)
        return float(model.body_subtreemass[model.body("FL_thigh").id]) - 0.2

    assert thigh("length", thigh_length=0.4) == pytest.approx(1.6)
    assert thigh("length", thigh_radius=0.04) == pytest.approx(0.8)
    # Half of the mass is payload.
    assert thigh("shell", thigh_length=0.4) == pytest.approx(0.4 + 0.8)
    assert thigh("shell", thigh_radius=0.04) == pytest.approx(0.4 + 0.8)
    assert set(MASS_MODES) == {"density", "shell", "length"}


def test_a_longer_link_moves_what_hangs_on_it_and_its_inertia_grows(dog: Robot) -> None:
    model = compiled(dog, "length", thigh_length=0.4)
    assert model.body("FL_calf").pos == pytest.approx((0, 0, -0.4))
    assert model.geom("FL_upper").size[:2] == pytest.approx((0.02, 0.2))
    # A rod of twice the length and mass has eight times the inertia across.
    assert max(model.body("FL_thigh").inertia) == pytest.approx(8 * 0.0028 + 2 * 0.0002, rel=0.01)


def test_strength_is_a_torque(dog: Robot) -> None:
    model = compiled(dog, "length", hip_strength=7.0)
    assert model.actuator("FL_hip").forcerange == pytest.approx((-7, 7))
    assert model.actuator("FL_knee").forcerange == pytest.approx((-20, 20))


def test_solids_of_the_template_are_those_of_the_compiled_robot(dog: Robot, tmp_path: Path) -> None:
    writer = TemplateWriter(dog, EDITS)
    values = REFERENCE | {"thigh_length": 0.31, "thigh_radius": 0.03}
    model = mujoco.MjSpec.from_string(fill(writer.text(), values)).compile()
    volume = sum(one.volume for one in solids(writer.text(), values))
    assert volume == pytest.approx(model_volume(model), rel=1e-6)
    # That of a mesh follows its scale.
    arm = read_robot(write_arm(tmp_path), "fixed")
    edits = (Edit("tool_length", "length", ("tool",), 0.125),)
    writer = TemplateWriter(arm, edits)
    sizes = []
    for length in (0.125, 0.25):
        text = fill(writer.text(), {"tool_length": length})
        model = mujoco.MjSpec.from_string(text, assets=arm.assets).compile()
        named = solids(writer.text(), {"tool_length": length}, writer.mesh_volumes)
        sizes.append(sum(one.volume for one in named))
        assert sizes[-1] == pytest.approx(model_volume(model), rel=1e-5)
    shell = 0.1**3 / 6
    assert sizes[1] - sizes[0] == pytest.approx(shell, rel=1e-4)


BARS = """<mujoco model="bars"><compiler angle="radian"/>
<asset><mesh file="flat.obj"/><mesh file="upright.obj"/></asset><worldbody><body name="base">
<geom type="box" size="0.05 0.05 0.05"/>
<body name="upper" pos="0 0 0.1"><joint name="j1" axis="0 1 0"/>
<geom name="flat" type="mesh" mesh="flat"/>
<body name="fore" pos="0.3 0 0"><joint name="j2" axis="0 1 0"/>
<geom name="turned" type="mesh" mesh="upright" euler="0 1.5707963 0"/>
</body></body></body></worldbody></mujoco>"""


def bar(x: float, y: float, z: float) -> str:
    """Return a box from (0, -y, -z) to (x, y, z) as the text of an OBJ file."""
    corners = [(u, v, w) for u in (0, x) for v in (-y, y) for w in (-z, z)]
    sides = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    lines = [f"v {u} {v} {w}" for u, v, w in corners] + [f"f {side}" for side in sides]
    return "\n".join(lines) + "\n"


def sides(model: mujoco.MjModel, geom: str) -> np.ndarray:
    """Return the lowest and the highest corner (2, 3) of a mesh in the world, in m."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mesh = int(model.geom(geom).dataid[0])
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    corners = model.mesh_vert[first : first + count] @ data.geom(geom).xmat.reshape(3, 3).T
    corners += data.geom(geom).xpos
    return np.stack((corners.min(0), corners.max(0)))


@pytest.mark.parametrize("factor", [0.6, 1.0, 1.9])
def test_a_mesh_grows_along_its_link_wherever_it_lies_in_its_file(
    tmp_path: Path, factor: float
) -> None:
    (tmp_path / "flat.obj").write_text(bar(0.3, 0.03, 0.02))
    # From its middle on, so that turned about y it goes from 0 to 0.3 in x.
    (tmp_path / "upright.obj").write_text(bar(0.04, 0.02, 0.15))
    (tmp_path / "bars.xml").write_text(BARS)
    robot = read_robot(tmp_path / "bars.xml")
    links = ("upper", "fore")
    edits = [Edit(f"{n}_length", "length", (n,), 0.3) for n in links]
    edits += [Edit(f"{n}_radius", "radius", (n,), 0.02) for n in links]
    text = TemplateWriter(robot, edits).text()
    reference = {edit.name: edit.reference for edit in edits}

    def at(**changed: float) -> mujoco.MjModel:
        filled = fill(text, reference | changed)
        return mujoco.MjSpec.from_string(filled, assets=robot.assets).compile()

    before, after = at(), at(upper_length=0.3 * factor)
    grown = sides(before, "flat") * (factor, 1, 1)
    np.testing.assert_allclose(sides(after, "flat"), grown, atol=1e-5)
    moved = sides(before, "turned") + np.array((0.3 * (factor - 1), 0, 0))
    np.testing.assert_allclose(sides(after, "turned"), moved, atol=1e-5)
    for name, changed in (("turned", "fore_length"), ("flat", "upper_radius")):
        after = at(**{changed: factor * reference[changed]})
        wanted = (factor, 1, 1) if changed.endswith("length") else (1, factor, factor)
        spans = np.ptp(sides(after, name), axis=0) / np.ptp(sides(before, name), axis=0)
        np.testing.assert_allclose(spans, wanted, atol=1e-4)


@pytest.mark.parametrize(
    ("classes", "worn"),
    [
        ('<default><mesh scale="0.001 -0.001 0.001"/></default>', ""),
        (
            '<default><default class="mm"><mesh scale="0.001 -0.001 0.001"/></default></default>',
            'class="mm"',
        ),
    ],
)
def test_a_mesh_keeps_the_scale_that_its_class_says(
    tmp_path: Path, classes: str, worn: str
) -> None:
    (tmp_path / "flat.obj").write_text(bar(300, 30, 20))
    (tmp_path / "upright.obj").write_text(bar(40, 20, 150))
    text = BARS.replace("<asset>", f"{classes}<asset>").replace("<mesh file", f"<mesh {worn} file")
    (tmp_path / "bars.xml").write_text(text)
    robot = read_robot(tmp_path / "bars.xml")
    edits = [Edit("upper_length", "length", ("upper",), 0.3)]
    filled = fill(TemplateWriter(robot, edits).text(), {"upper_length": 0.3})
    made = mujoco.MjSpec.from_string(filled, assets=robot.assets).compile()
    for name in ("flat", "turned"):
        np.testing.assert_allclose(
            sides(made, name), sides(robot.spec().compile(), name), atol=1e-5
        )


HUNG_FROM_THE_MIDDLE = """<mujoco><worldbody><body name="torso" pos="0 0 1"><freejoint/>
<geom type="box" size="0.2 0.1 0.05" mass="4"/>
<body name="thigh" pos="0 0 -0.2"><joint name="hip" axis="0 1 0" pos="0 0 0.2"/>
<geom name="upper" type="capsule" fromto="0 0 0.2 0 0 -0.2" size="0.03"/>
<body name="shin" pos="0 0 -0.4" euler="0 90 0"><joint name="knee" axis="0 1 0" pos="-0.2 0 0"/>
<geom name="lower" type="capsule" fromto="-0.2 0 0 0.2 0 0" size="0.03"/>
</body></body></body></worldbody></mujoco>"""


def test_a_link_is_stretched_from_its_joint_wherever_its_frame_is(tmp_path: Path) -> None:
    (tmp_path / "middle.xml").write_text(HUNG_FROM_THE_MIDDLE)
    robot = read_robot(tmp_path / "middle.xml")
    links = find_links(robot.spec().compile())
    assert links["thigh"].length == pytest.approx(0.4)
    assert links["shin"].length == pytest.approx(0.4)
    edits = [Edit(f"{name}_length", "length", (name,), 0.4) for name in ("thigh", "shin")]
    text = TemplateWriter(robot, edits).text()
    for thigh, shin in ((0.4, 0.4), (0.76, 0.4), (0.4, 0.76), (0.25, 0.5)):
        filled = fill(text, {"thigh_length": thigh, "shin_length": shin})
        model = mujoco.MjSpec.from_string(filled).compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        hip, knee = (data.joint(name).xanchor[2] for name in ("hip", "knee"))
        assert hip == pytest.approx(data.body("torso").xpos[2])
        assert knee == pytest.approx(hip - thigh)
        for geom, top, length in (("upper", hip, thigh), ("lower", knee, shin)):
            assert data.geom(geom).xpos[2] == pytest.approx(top - length / 2)
            assert model.geom(geom).size[1] == pytest.approx(length / 2)


FRAMED = """<mujoco><default><default class="stiff"><joint damping="2" armature="0.01"/>
<geom density="200"/></default></default><worldbody><frame pos="0 0 1"><body name="torso">
<freejoint/><geom size="0.1"/>
<frame childclass="stiff" pos="0 0.1 -0.1"><body name="left"><joint name="l" axis="0 1 0"/>
<geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.2"/></body></frame>
<body name="right" pos="0 -0.1 -0.1"><frame childclass="stiff"><frame><joint name="r" axis="0 1 0"/>
</frame><geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.2"/></frame></body>
</body></frame></worldbody></mujoco>"""


def test_what_stands_in_frames_keeps_its_class_and_is_stretched(tmp_path: Path) -> None:
    (tmp_path / "framed.xml").write_text(FRAMED)
    robot = read_robot(tmp_path / "framed.xml")
    text = TemplateWriter(robot, [Edit("leg", "length", ("left", "right"), 0.2)]).text()
    before = robot.spec().compile()
    after = mujoco.MjSpec.from_string(fill(text, {"leg": 0.2})).compile()
    assert before.joint("l").damping == 2
    np.testing.assert_array_equal(after.dof_damping, before.dof_damping)
    np.testing.assert_array_equal(after.dof_armature, before.dof_armature)
    np.testing.assert_allclose(after.body_mass, before.body_mass, rtol=1e-5)
    longer = mujoco.MjSpec.from_string(fill(text, {"leg": 0.3})).compile()
    assert longer.geom("right").size[1] == pytest.approx(0.15)


def test_amounts_are_written_as_a_person_would() -> None:
    length = Amount({("thigh",): 1.0})
    assert texts([0.5, length, -length, 0.02 + 0.5 * length, length * length * 2]) == (
        "0.5 {thigh} {-thigh} {0.02 + 0.5*thigh} {2*thigh*thigh}"
    )
    assert texts([1e-12 + 0 * length]) == "0"
