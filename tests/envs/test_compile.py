"""From parameters to models, and the plain facts of a body."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from robomore.envs import union
from robomore.envs.compile import body_facts, compile_model
from robomore.errors import InvalidMorphology
from robomore.tasks import Task, get_task
from robomore.tasks.registry import PAPER_TASKS

REFERENCE = {  # mass in kg, density in kg/m^3, height of the torso in m
    "ant": (0.910880, 5, math.hypot(0.4, 0.4) + 0.15),
    "ant-powered": (0.910880, 5, math.hypot(0.4, 0.4) + 0.15),
    "ant-desert": (0.910880, 5, math.hypot(0.4, 0.4) + 0.15),
    "ant-jump": (0.910880, 5, math.hypot(0.4, 0.4) + 0.15),
    "hopper": (15.820013, 1000, 1.25),
    "half-cheetah": (14, 660.885, 0.54354),
    "swimmer": (106.814150, 1000, 0),
    "walker": (23.677137, 1000, 1.25),
}


@pytest.fixture(params=PAPER_TASKS, ids=lambda task: task.id)
def task(request: pytest.FixtureRequest) -> Task:
    chosen: Task = request.param
    return chosen


def test_facts_of_the_reference_body(task: Task) -> None:
    facts = body_facts(task, task.reference)
    mass, density, height = REFERENCE[task.id]
    assert facts["mass"] == pytest.approx(mass, abs=1e-6)
    assert facts["density"] == pytest.approx(density, abs=1e-3)
    assert facts["rest_height"] == pytest.approx(height, abs=1e-9)
    assert facts["volume"] == task.volume(task.reference)


def test_root_of_hopper_and_walker_stands_at_its_own_height() -> None:
    for id in ("hopper", "walker"):
        task = get_task(id)
        body = dict(zip(task.names, task.reference, strict=True)) | {"torso_top": 2.0}
        model = compile_model(task, body)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        assert data.qpos[1] == data.body("torso").xpos[2] == pytest.approx((2.0 + 1.05) / 2)


def test_compiling_says_nothing(
    task: Task, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Deprecated attributes would warn on stderr and leave a log file."""
    monkeypatch.chdir(tmp_path)
    compile_model(task, task.reference)
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())


def test_refused_parameters_are_not_compiled(task: Task) -> None:
    with pytest.raises(InvalidMorphology, match=task.names[0]):
        compile_model(task, [99.0, *task.reference[1:]])


def test_what_mujoco_refuses_is_an_invalid_morphology() -> None:
    swimmer = get_task("swimmer")
    broken = replace(swimmer, template=swimmer.template.replace('size="{back_radius}"', 'size="0"'))
    with pytest.raises(InvalidMorphology, match=r"swimmer: MuJoCo refuses this morphology: .*size"):
        compile_model(broken, swimmer.reference)


def test_same_parameters_give_the_same_model(task: Task) -> None:
    first, second = (compile_model(task, task.reference) for _ in range(2))
    sizes = [mujoco.mj_sizeModel(model) for model in (first, second)]
    buffers = [np.zeros(size, np.uint8) for size in sizes]
    for model, buffer in zip((first, second), buffers, strict=True):
        mujoco.mj_saveModel(model, None, buffer)
    np.testing.assert_array_equal(*buffers)


def test_union_is_the_sum_less_what_neighbours_share(task: Task) -> None:
    pytest.importorskip("manifold3d")
    filled = union.union_volume(task, task.reference)
    assert filled is not None
    assert 0.7 * task.volume(task.reference) < filled < task.volume(task.reference)


def test_union_of_a_straight_rod() -> None:
    """Three equal links in a row are one capsule of three lengths."""
    pytest.importorskip("manifold3d")
    swimmer = get_task("swimmer")
    filled = union.union_volume(swimmer, swimmer.reference)
    assert filled == pytest.approx(math.pi * 0.1**2 * (3 + 4 * 0.1 / 3), rel=1e-3)


def test_both_legs_of_walker_count() -> None:
    pytest.importorskip("manifold3d")
    walker, hopper = get_task("walker"), get_task("hopper")
    one, two = (union.union_volume(task, walker.reference) for task in (hopper, walker))
    assert one is not None and two is not None
    ball = 4 / 3 * math.pi * 0.05**3  # what the torso shares with each thigh
    torso = walker.solids(walker.named(walker.reference))[0].volume
    assert two - torso == pytest.approx(2 * (one - torso), abs=0.02 * ball)


def test_union_needs_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(union, "find_spec", lambda name: None)
    assert union.union_volume(get_task("swimmer"), get_task("swimmer").reference) is None
