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
    # A mesh is scaled along the axis that is nearest to the link's.
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


def test_amounts_are_written_as_a_person_would() -> None:
    length = Amount({("thigh",): 1.0})
    assert texts([0.5, length, -length, 0.02 + 0.5 * length, length * length * 2]) == (
        "0.5 {thigh} {-thigh} {0.02 + 0.5*thigh} {2*thigh*thigh}"
    )
    assert texts([1e-12 + 0 * length]) == "0"
