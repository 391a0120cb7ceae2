"""What holds for any morphology that a task accepts."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_morphologies import at, random_body

from paper import PAPER
from robomore.envs.compile import body_facts, compile_model
from robomore.envs.vector_env import VectorEnv
from robomore.errors import InvalidMorphology, UnstableSimulation
from robomore.tasks import ant, get_task, half_cheetah
from robomore.tasks.swimmer import least_radius
from robomore.tasks.task import Values

SEEDS = st.integers(0, 2**32 - 1)
FRAME_SKIP = {"ant": 5, "hopper": 4, "half-cheetah": 5, "swimmer": 4, "walker": 4}
CONTROL_STEPS = 200
STEPS = 1_000

slow = settings(
    max_examples=4, deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize=True
)
quick = settings(max_examples=15, deadline=None, derandomize=True)


@pytest.mark.parametrize("id", PAPER)
@slow
@given(seed=SEEDS)
def test_any_valid_body_compiles_and_simulates(id: str, seed: int) -> None:
    task = get_task(id)
    model = compile_model(task, random_body(task, seed))
    data = mujoco.MjData(model)
    random = np.random.default_rng(seed)
    steps = FRAME_SKIP[next(name for name in FRAME_SKIP if id.startswith(name))]
    for step in range(CONTROL_STEPS):
        if step % 4 == 0:  # full torques, held: harder than what noise does
            data.ctrl[:] = random.choice([-1, 1], model.nu)
        mujoco.mj_step(model, data, nstep=steps)
    assert np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all()
    assert not [warning.lastinfo for warning in data.warning if warning.number]


@pytest.mark.parametrize(
    "id",
    [
        *("ant-powered", "half-cheetah", "hopper", "swimmer", "walker"),
        # The same class on other ground, with weaker motors or another reward.
        *(
            pytest.param(id, marks=pytest.mark.exhaustive)
            for id in ("ant", "ant-desert", "ant-jump")
        ),
    ],
)
@settings(slow, max_examples=2)
@given(seed=SEEDS, held=st.sampled_from([1, 4, 25]))
def test_a_thousand_steps_of_any_valid_body_are_finite_or_called_unstable(
    id: str, seed: int, held: int
) -> None:
    """As in training: episodes start over, and what diverges is told from what is measured."""
    task = get_task(id)
    simulations = VectorEnv(task, random_body(task, seed), 2)
    random = np.random.default_rng(seed)
    try:
        seen = simulations.reset(seed % 2**31)
        assert np.isfinite(seen).all()
        for step in range(STEPS):
            if step % held == 0:
                actions = random.choice([-1.0, 1.0], (2, simulations.action_size))
            stepped = simulations.step(actions)
            assert np.isfinite(stepped.reward).all()
            assert np.isfinite(stepped.observation).all()
            assert np.isfinite(stepped.final_observation).all()
    except UnstableSimulation as error:
        assert str(error)


@pytest.mark.parametrize("id", PAPER)
@quick
@given(shares=st.lists(st.floats(0, 1), min_size=24, max_size=24))
def test_anything_in_bounds_compiles_or_is_refused_in_words(id: str, shares: list[float]) -> None:
    """Not only what passes the rules: the refusal names the rule and stops short of MuJoCo."""
    task = get_task(id)
    body = [at(p, share) for p, share in zip(task.parameters, shares, strict=False)]
    try:
        checked = task.check(body)
    except InvalidMorphology as error:
        assert len(str(error)) > 20
        return
    model = compile_model(task, checked)
    assert task.volume(checked) > 0 and np.isfinite(model.body_mass).all()


@pytest.mark.parametrize("id", PAPER)
@quick
@given(seed=SEEDS)
def test_facts_are_positive_and_agree(id: str, seed: int) -> None:
    task = get_task(id)
    body = random_body(task, seed)
    facts = body_facts(task, body)
    assert facts["volume"] > 0 and facts["mass"] > 0
    assert facts["mass"] == pytest.approx(facts["density"] * facts["volume"])
    expected = 14 / facts["volume"] if id == "half-cheetah" else 5 if "ant" in id else 1000
    assert facts["density"] == pytest.approx(expected, rel=1e-6)
    assert facts["rest_height"] > 0 or id == "swimmer"


@pytest.mark.parametrize("id", PAPER)
@quick
@given(seed=SEEDS)
def test_volume_is_that_of_the_simulated_parts(id: str, seed: int) -> None:
    """Computed without MuJoCo, and here from the model that MuJoCo made."""
    task = get_task(id)
    body = random_body(task, seed)
    model = compile_model(task, body)
    parts = model.geom_bodyid > 0
    radius, half = model.geom_size[parts, :2].T
    balls = model.geom_type[parts] == mujoco.mjtGeom.mjGEOM_SPHERE
    rods = np.where(balls, 0, 2 * half)
    expected = np.sum(np.pi * radius**2 * (rods + 4 / 3 * radius))
    assert task.volume(body) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("id", PAPER)
@quick
@given(seed=SEEDS, share=st.floats(0, 1), data=st.data())
def test_volume_grows_with_every_radius(
    id: str, seed: int, share: float, data: st.DataObject
) -> None:
    task = get_task(id)
    body = dict(zip(task.names, random_body(task, seed), strict=True))
    name = data.draw(st.sampled_from([name for name in task.names if name.endswith("radius")]))
    parameter = task.parameters[task.names.index(name)]
    thicker = max(at(parameter, share), body[name])
    try:
        volume = task.volume(body | {name: thicker})
    except InvalidMorphology:
        return
    assert volume >= task.volume(body)
    assert (volume > task.volume(body)) == (thicker > body[name])


@pytest.mark.parametrize("id", PAPER)
@quick
@given(seed=SEEDS, by=st.floats(1e-6, 1e3), data=st.data())
def test_outside_the_bounds_is_refused(id: str, seed: int, by: float, data: st.DataObject) -> None:
    task = get_task(id)
    body = list(random_body(task, seed))
    index = data.draw(st.integers(0, len(body) - 1))
    parameter = task.parameters[index]
    body[index] = data.draw(st.sampled_from([parameter.low - by, parameter.high + by]))
    with pytest.raises(InvalidMorphology, match=parameter.name):
        task.check(body)


@pytest.mark.parametrize("id", ["hopper", "walker", "ant"])
@quick
@given(seed=SEEDS)
def test_nobody_is_born_unhealthy(id: str, seed: int) -> None:
    """Whatever the reset noise (0.1 m for Ant, 0.005 m for the others)."""
    task = get_task(id)
    body = random_body(task, seed)
    low, high = task.options(task.named(body))["healthy_z_range"]
    height = body_facts(task, body)["rest_height"]
    noise = 0.1 if id == "ant" else 0.005
    assert low <= height - noise and height + noise <= high


@pytest.mark.parametrize("id", [id for id in PAPER if id not in ("swimmer", "half-cheetah")])
@quick
@given(seed=SEEDS)
def test_nothing_touches_at_the_start(id: str, seed: int) -> None:
    """Neither the ground nor, for a Hopper, whose parts alone collide, another part."""
    task = get_task(id)
    model = compile_model(task, random_body(task, seed))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert not data.ncon or data.contact.dist.min() >= -1e-9


@pytest.mark.parametrize(
    ("id", "start_height"),
    [("half-cheetah", half_cheetah.start_height), ("ant", ant.start_height)],
)
@quick
@given(seed=SEEDS)
def test_the_start_height_of_the_rules_is_that_of_the_model(
    id: str, start_height: Callable[[Values], float], seed: int
) -> None:
    """The template and the rules for samplers each have the formula."""
    task = get_task(id)
    body = task.named(random_body(task, seed))
    height = float(compile_model(task, body).body_pos[1, 2])
    assert height == pytest.approx(start_height(body), rel=1e-12)


@pytest.mark.parametrize(
    ("shortest", "radius"), [(0.1, 0.03), (0.5, 0.03), (0.85, 0.02), (1.0, 0.017), (2.5, 0.01)]
)
def test_least_radius_of_a_swimmer(shortest: float, radius: float) -> None:
    """By hand: 0.017 m² over the shortest length, between 1 and 3 cm."""
    assert least_radius(shortest) == pytest.approx(radius)
