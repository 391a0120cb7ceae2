"""What a control step costs over the bare physics, for each robot.

Each step is done four times from the same states with the same actions, one right after the other:
bare `mj_step` of all simulations, `Simulations` without a reward, with the reference reward run for
the whole batch, and with the same run once per simulation. Medians over steps of the thread's own
processor time.

    python benchmarks/simulation.py [--simulations 16] [--steps 300]
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from functools import partial

os.environ.setdefault("OMP_NUM_THREADS", "1")

import mujoco
import numpy as np

from robomore.tasks import get_task
from robomore.tasks.reward_text import reward_function
from robomore.tasks.simulation import Simulations

ROBOTS = ("ant", "half-cheetah", "hopper", "walker", "swimmer")
WARM_UP = 40
"""Steps before the measurement, more than those in which batched rewards are checked."""

STATE = mujoco.mjtState.mjSTATE_INTEGRATION


def measure(robot: str, n: int, steps: int) -> list[float]:
    """Return microseconds per simulation and control step: bare, without and with rewards."""
    task = get_task(robot)
    reward = reward_function(task.reward)
    led = Simulations(task, task.human, n, reward)
    others = [
        Simulations(task, task.human, n),
        Simulations(task, task.human, n, reward, batched=False),
    ]
    bare = [mujoco.MjData(led.model) for _ in range(n)]
    model, frame_skip = led.model, led.environment.frame_skip
    row = np.empty(mujoco.mj_stateSize(model, STATE))
    random = np.random.default_rng(0)
    for simulations in (led, *others):
        simulations.reset(0)

    def physics() -> None:
        for data in bare:
            mujoco.mj_step(model, data, frame_skip)

    times = np.empty((steps + WARM_UP, 4))
    for step in range(len(times)):
        actions = random.uniform(-1, 1, (n, led.action_size))
        for i, action in enumerate(actions):
            mujoco.mj_getState(model, led.data[i], row, STATE)
            for target in (bare[i], *(other.data[i] for other in others)):
                mujoco.mj_setState(model, target, row, STATE)
            bare[i].ctrl[:] = action
        sides: list[Callable[[], object]] = [
            physics,
            *(partial(one.step, actions) for one in (others[0], led, others[1])),
        ]
        # In turn, so that none always finds the caches warm.
        for side in np.roll(range(len(sides)), step):
            began = time.thread_time()
            sides[side]()
            times[step, side] = time.thread_time() - began
    assert "whole batch" in led.notes()[0]
    return list(np.median(times[WARM_UP:], axis=0) / n * 1e6)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--simulations", type=int, default=16)
    parser.add_argument("--steps", type=int, default=300)
    options = parser.parse_args()
    print(f"{options.simulations} simulations, microseconds per simulation and control step,")
    print("and their ratio to the bare physics")
    heads = ("mj_step", "no reward", "batched reward", "one reward each")
    print(f"{'robot':<14}{heads[0]:>10}" + "".join(f"{head:>19}" for head in heads[1:]))
    for robot in ROBOTS:
        bare, *sides = measure(robot, options.simulations, options.steps)
        columns = "".join(f"{side:>12.1f}{side / bare:>7.2f}" for side in sides)
        print(f"{robot:<14}{bare:>10.1f}{columns}")


if __name__ == "__main__":
    main()
