"""The robots and grounds of the side studies are the ones that their names promise."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from robomore.envs import terrain
from robomore.envs.compile import compile_model
from robomore.tasks import Terrain, get_task
from robomore.tasks.variants import VARIANTS

GEARS = {f"ant-powered-{gear}": float(gear) for gear in (50, 100, 150, 200, 250)}

GROUNDS = {
    # Half-correlation length in m, root-mean-square slope, friction.
    "ant-desert": (4.6, 0.077, 0.4),
    "ant-snow": (3.4, 0.096, 0.3),
    "ant-hills": (2.3, 0.156, 1.0),
}
"""The paper's grounds that rise and fall."""


def test_every_variant_is_tried_below() -> None:
    assert set(VARIANTS) == {*GEARS, *GROUNDS, "ant-ground"} - {"ant-desert"}


@pytest.mark.parametrize(("id", "gear"), [*GEARS.items(), ("ant-powered", 300.0)])
def test_each_weaker_ant_has_its_gear_on_flat_ground(id: str, gear: float) -> None:
    task = get_task(id)
    model = compile_model(task, task.reference)
    assert set(model.actuator_gear[:, 0].tolist()) == {gear} and model.nu == 8
    assert model.nhfield == 0 and task.terrain is None
    assert task.options(task.named(task.reference)) == {"healthy_z_range": (0.0, 10.0)}


@pytest.mark.parametrize(("id", "figures"), GROUNDS.items())
def test_each_rough_ground_is_the_paper_s(id: str, figures: tuple[float, float, float]) -> None:
    task = get_task(id)
    model = compile_model(task, task.reference)
    correlation, slope, friction = figures
    assert set(model.actuator_gear[:, 0].tolist()) == {150.0}
    assert task.options(task.named(task.reference)) == {"healthy_z_range": (-10.0, 10.0)}
    assert model.nhfield == 1 and model.hfield_size[0, 2] == 1.5
    cells = (int(model.hfield_nrow[0]), int(model.hfield_ncol[0]))
    field = model.hfield_data.reshape(cells)[:-1, :-1].astype(float)
    assert terrain.half_correlation(field) == pytest.approx(correlation, rel=0.05)
    assert terrain.rms_slope(field, 1.5) == pytest.approx(slope, rel=0.03)
    assert field.min() >= 0 and field.max() <= 1
    assert field.std() == pytest.approx(46 / 255, rel=0.02)
    assert field.mean() == pytest.approx(120 / 255, rel=0.01)
    assert frictions(model) == {friction}


def test_the_flat_ground_of_the_terrain_study_is_a_firm_plane() -> None:
    task = get_task("ant-ground")
    model = compile_model(task, task.reference)
    assert model.nhfield == 0 and frictions(model) == {1.0}
    assert set(model.actuator_gear[:, 0].tolist()) == {150.0}
    assert task.options(task.named(task.reference)) == {"healthy_z_range": (-10.0, 10.0)}


def test_no_two_of_them_are_one_ground() -> None:
    grounds = [get_task(id).terrain for id in (*GROUNDS, "ant-ground")]
    assert all(isinstance(one, Terrain) for one in grounds)
    assert len(set(grounds)) == 4


def frictions(model: mujoco.MjModel) -> set[float]:
    """Return the sliding frictions with which an Ant that was dropped touches the ground."""
    data = mujoco.MjData(model)
    for _ in range(300):
        mujoco.mj_step(model, data)
    assert data.ncon and np.isfinite(data.qpos).all()
    return {float(contact.friction[0]) for contact in data.contact}
