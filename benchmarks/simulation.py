"""What a control step costs over the bare physics, for each robot.

Each step is done three times from the same states with the same actions, one right after the other:
bare `mj_step` of all simulations, `VectorEnv` without a reward, and `VectorEnv` with the
reference reward. Medians over steps of the thread's own processor time.

    python benchmarks/simulation.py [--num-envs 16] [--steps 300] [--replace-rk4]

With `--replace-rk4` the robots that integrate by RK4 have implicitfast at half the timestep, as
`crossq` trains them.
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
"""Steps before the measurement."""

STATE = mujoco.mjtState.mjSTATE_INTEGRATION


def measure(robot: str, num_envs: int, steps: int, replace_rk4: bool) -> list[float]:
    """Return microseconds per simulation and control step: bare, without and with reward."""
    task = get_task(robot)
    reward = reward_function(task.reward)
    rewarded = VectorEnv(task, task.reference, num_envs, reward, replace_rk4=replace_rk4)
    unrewarded = VectorEnv(task, task.reference, num_envs, replace_rk4=replace_rk4)
    bare = [mujoco.MjData(rewarded.model) for _ in range(num_envs)]
    model, frame_skip = rewarded.model, rewarded.environment.frame_skip
    row = np.empty(mujoco.mj_stateSize(model, STATE))
    random = np.random.default_rng(0)
    rewarded.reset(0)
    unrewarded.reset(0)

    def physics() -> None:
        for data in bare:
            mujoco.mj_step(model, data, frame_skip)

    times = np.empty((steps + WARM_UP, 3))
    for step in range(len(times)):
        actions = random.uniform(-1, 1, (num_envs, rewarded.action_size))
        for source, plain, other, action in zip(
            rewarded.data, bare, unrewarded.data, actions, strict=True
        ):
            mujoco.mj_getState(model, source, row, STATE)
            for target in (plain, other):
                mujoco.mj_setState(model, target, row, STATE)
            plain.ctrl[:] = action
        sides: list[Callable[[], object]] = [
            physics,
            partial(unrewarded.step, actions),
            partial(rewarded.step, actions),
        ]
        # In turn, so that none always finds the caches warm.
        for side in np.roll([0, 1, 2], step):
            began = time.thread_time()
            sides[side]()
            times[step, side] = time.thread_time() - began
    return list(np.median(times[WARM_UP:], axis=0) / num_envs * 1e6)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--num-envs", type=int, default=16)
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument("--replace-rk4", action="store_true")
    options = parser.parse_args()
    print(f"{options.num_envs} simulations, microseconds per simulation and control step,")
    print("and ratios to the bare physics")
    print(f"{'robot':<14}{'mj_step':>10}{'no reward':>18}{'reward':>18}")
    for robot in ROBOTS:
        bare, *sides = measure(robot, options.num_envs, options.steps, options.replace_rk4)
        columns = "".join(f"{side:>11.1f}{side / bare:>7.2f}" for side in sides)
        print(f"{robot:<14}{bare:>10.1f}{columns}")


if __name__ == "__main__":
    main()
