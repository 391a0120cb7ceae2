"""Generated ground: its statistics, its seams, and robots upon it."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from robomore.envs import terrain
from robomore.envs.compile import body_facts, compile_model
from robomore.tasks import Terrain, get_task
from robomore.tasks import terrain as ground

ROUGH = ("ant-desert", "ant-snow", "ant-hills")


def test_statistics_hold_for_other_seeds() -> None:
    other = replace(ground.DESERT, seed=77)
    field = terrain.tile(other)[:-1, :-1]
    assert not np.allclose(field, terrain.tile(ground.DESERT)[:-1, :-1])
    assert terrain.rms_slope(field, 1.5) == pytest.approx(0.077, rel=0.03)
    assert terrain.half_correlation(field) == pytest.approx(4.6, rel=0.1)


def test_measures_on_known_ground() -> None:
    """Waves of 16 m along x and y: correlation (1 + cos(2 pi d / 16)) / 2, one half at 4 m."""
    x = np.arange(ground.CELLS) * ground.TILE / ground.CELLS
    wave = np.sin(2 * np.pi * x / 16)
    field = 0.5 + 0.1 * (wave[:, None] + wave[None, :])
    assert terrain.half_correlation(field) == pytest.approx(4, rel=1e-3)
    slope = 2.0 * 0.1 * (2 * np.pi / 16) * np.sqrt(0.5)
    assert terrain.rms_slope(field, height=2.0) == pytest.approx(slope, rel=0.01)


@pytest.mark.parametrize("id", ROUGH)
def test_tiles_join_without_a_seam(id: str) -> None:
    wanted = get_task(id).terrain
    assert wanted is not None
    closed = terrain.tile(wanted)
    np.testing.assert_array_equal(closed[0], closed[-1])
    np.testing.assert_array_equal(closed[:, 0], closed[:, -1])
    inside = np.abs(np.diff(closed, axis=1))
    across = np.abs(closed[:, 1] - closed[:, -2]) / 2
    assert across.mean() < 2 * inside.mean()
    assert across.max() <= inside.max()


def test_the_same_seed_gives_the_same_ground() -> None:
    first = terrain.tile(ground.SNOW)
    terrain.tile.cache_clear()
    np.testing.assert_array_equal(terrain.tile(ground.SNOW), first)


@pytest.mark.parametrize("id", ROUGH)
@pytest.mark.parametrize("low", [False, True], ids=["reference", "low and wide"])
def test_robot_starts_above_the_ground_whatever_its_size(id: str, low: bool) -> None:
    """The low one's limbs reach dunes that are higher than the ground beneath its torso."""
    ant, task = get_task("ant"), get_task(id)
    body = dict(zip(ant.names, ant.reference, strict=True))
    if low:
        body |= {
            "leg_x": 2.0, "leg_y": 2.0, "hip_x": 1.0, "hip_y": 1.0, "foot_x": 0.08, "foot_y": 0.08,
            "torso_radius": 0.05, "hip_radius": 0.01, "leg_radius": 0.01, "foot_radius": 0.01,
        }  # fmt: skip
    model = compile_model(task, body)
    data = mujoco.MjData(model)
    data.qpos[:3] -= 0.1  # the largest reset noise
    mujoco.mj_forward(model, data)
    assert not data.ncon or data.contact.dist.min() > 0
    flat = body_facts(ant, body)["rest_height"]
    assert body_facts(task, body)["rest_height"] == pytest.approx(flat, abs=1e-9)


@pytest.mark.parametrize("place", [(0, 0), (32, 5), (96, -32), (700, 140), (-90, -150)])
def test_a_dropped_robot_comes_to_rest_on_the_surface(place: tuple[float, float]) -> None:
    model = compile_model(get_task("ant-desert"), get_task("ant-desert").reference)
    data = mujoco.MjData(model)
    data.qpos[:2] = place
    surface = elevation(ground.DESERT, *place)
    data.qpos[2] = surface + 1.2
    for _ in range(400):
        mujoco.mj_step(model, data)
    above = data.qpos[2] - elevation(ground.DESERT, *data.qpos[:2])
    assert 0.2 < above < 0.9
    assert not any(warning.number for warning in data.warning)


def test_beyond_the_tiles_the_ground_is_flat() -> None:
    model = compile_model(get_task("ant-desert"), get_task("ant-desert").reference)
    data = mujoco.MjData(model)
    data.qpos[:3] = -300, 0, 1
    for _ in range(400):
        mujoco.mj_step(model, data)
    assert 0.2 < data.qpos[2] < 0.9


def test_tiles_reach_far_enough_for_50_s_at_15_metres_a_second() -> None:
    model = compile_model(get_task("ant-desert"), get_task("ant-desert").reference)
    tiles = model.geom_type == mujoco.mjtGeom.mjGEOM_HFIELD
    assert model.geom_pos[tiles, 0].max() + ground.TILE / 2 >= 750
    assert model.geom_pos[tiles, 0].min() < 0
    assert np.abs(model.geom_pos[tiles, 1]).max() >= ground.TILE


def test_a_template_without_a_floor_is_refused() -> None:
    with pytest.raises(ValueError, match="floor"):
        ground.on_terrain("<mujoco/>", ground.SNOW)


def elevation(chosen: Terrain, x: float, y: float) -> float:
    """Return the surface's height at a place, from the four corners of its cell."""
    step = ground.TILE / ground.CELLS
    closed = chosen.height * terrain.tile(chosen)
    column, across = divmod((x + ground.TILE / 2) % ground.TILE / step, 1)
    row, down = divmod((y + ground.TILE / 2) % ground.TILE / step, 1)
    corners = closed[int(row) : int(row) + 2, int(column) : int(column) + 2]
    return float(np.array([1 - down, down]) @ corners @ np.array([1 - across, across]))
