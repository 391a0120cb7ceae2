"""RK4 replaced by something cheaper: where, and how near the motion stays."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from robots import OFFICIAL, simulations

from robomore.envs.vector_env import VectorEnv

RK4 = mujoco.mjtIntegrator.mjINT_RK4


@pytest.mark.parametrize("task", OFFICIAL)
def test_only_rk4_is_replaced_and_no_control_step_changes(task: str) -> None:
    own, cheap = simulations(task), simulations(task, replace_rk4=True)
    assert cheap.model.opt.integrator != RK4
    assert cheap.environment.dt == pytest.approx(own.environment.dt)
    if own.model.opt.integrator == RK4:
        assert cheap.model.opt.timestep == own.model.opt.timestep / 2
        assert cheap.environment.frame_skip == 2 * own.environment.frame_skip
    else:
        assert cheap.model.opt.timestep == own.model.opt.timestep


def test_time_goes_on_as_fast() -> None:
    own, cheap = simulations("walker"), simulations("walker", replace_rk4=True)
    for batch in (own, cheap):
        batch.reset(0)
        batch.step(np.zeros((2, batch.action_size)))
    assert cheap.data[0].time == pytest.approx(own.data[0].time)


def test_half_the_timestep_is_what_keeps_it_near_rk4() -> None:
    def distance(other: VectorEnv) -> float:
        own = simulations("ant")
        for batch in (own, other):
            batch.reset(3)
        random = np.random.default_rng(0)
        for _ in range(4):
            actions = random.uniform(-1, 1, (2, 8))
            own.step(actions)
            other.step(actions)
        return float(np.abs(own.qpos - other.qpos).max())

    coarse = simulations("ant")
    coarse.model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert 0 < distance(simulations("ant", replace_rk4=True)) < 0.8 * distance(coarse)
