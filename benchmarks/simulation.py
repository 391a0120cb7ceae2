"""What a control step costs over the bare physics, for each robot.

Each step is done three times from the same states with the same actions, one right after the other:
bare `mj_step` of all simulations, `VectorEnv` without a reward, and `VectorEnv` with the
reference reward, which runs for the whole batch; in another pass it runs once per simulation.
Medians over steps of the thread's own processor time.

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

from robomore.envs.reward_text import reward_function
from robomore.envs.vector_env import VectorEnv
from robomore.tasks import get_task

ROBOTS = ("ant", "half-cheetah", "hopper", "walker", "swimmer")
WARM_UP = 40
"""Steps before the measurement, more than those in which batched rewards are checked."""

STATE = mujoco.mjtState.mjSTATE_INTEGRATION


def measure(robot: str, n: int, steps: int, batched: bool = True) -> list[float]:
    """Return microseconds per simulation and control step: bare, without and with reward."""
    task = get_task(robot)
    led = VectorEnv(task, task.reference, n, reward_function(task.reward), batched=batched)
    unpaid = VectorEnv(task, task.reference, n)
    bare = [mujoco.MjData(led.model) for _ in range(n)]
    model, frame_skip = led.model, led.environment.frame_skip
    row = np.empty(mujoco.mj_stateSize(model, STATE))
    random = np.random.default_rng(0)
    led.reset(0)
    unpaid.reset(0)

    def physics() -> None:
        for data in bare:
            mujoco.mj_step(model, data, frame_skip)

    times = np.empty((steps + WARM_UP, 3))
    for step in range(len(times)):
        actions = random.uniform(-1, 1, (n, led.action_size))
        for source, plain, other, action in zip(led.data, bare, unpaid.data, actions, strict=True):
            mujoco.mj_getState(model, source, row, STATE)
            for target in (plain, other):
                mujoco.mj_setState(model, target, row, STATE)
            plain.ctrl[:] = action
        sides: list[Callable[[], object]] = [
            physics,
            partial(unpaid.step, actions),
            partial(led.step, actions),
        ]
        # In turn, so that none always finds the caches warm.
        for side in np.roll([0, 1, 2], step):
            began = time.thread_time()
            sides[side]()
            times[step, side] = time.thread_time() - began
    assert ("whole batch" in led.notes()[0]) == batched
    return list(np.median(times[WARM_UP:], axis=0) / n * 1e6)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--simulations", type=int, default=16)
    parser.add_argument("--steps", type=int, default=300)
    options = parser.parse_args()
    print(f"{options.simulations} simulations, microseconds per simulation and control step,")
    print("and ratios to the bare physics; the last one with a reward run once per simulation")
    print(f"{'robot':<14}{'mj_step':>10}{'no reward':>18}{'reward':>18}{'each':>8}")
    for robot in ROBOTS:
        bare, *sides = measure(robot, options.simulations, options.steps)
        plain, _, each = measure(robot, options.simulations, options.steps, batched=False)
        columns = "".join(f"{side:>11.1f}{side / bare:>7.2f}" for side in sides)
        print(f"{robot:<14}{bare:>10.1f}{columns}{each / plain:>8.2f}")


if __name__ == "__main__":
    main()
