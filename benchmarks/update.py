"""Gradient steps a second: our CrossQ, SBX's, and the bare matrix products that a step consists of.

    python benchmarks/update.py [--net-arch 256 256] [--batch-size 256] [--seconds 10]

All of them in this one process, on one core, in turns, so that a busy machine hurts all alike. Ours
has SBX's settings (`against_sbx.SAME`), two critics among them, and the bare products count two.
For SBX (optional): pip install sbx-rl
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from against_sbx import SAME
from robomore.training.crossq import CrossQ
from robomore.training.loop import TrainingRun
from robomore.training.settings import CrossQSettings, settings_from
from robomore.training.threads import use_one_thread
from robomore.training.trainer import Transition
from robomore.types import TrainerSettings

OBSERVATIONS, ACTIONS = 17, 6
UPDATES = 16
"""Gradient steps in one call, as in a round of training."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--net-arch", type=int, nargs="+", default=[256, 256])
    parser.add_argument("--batch-size", type=int, default=256)
    parser.add_argument("--seconds", type=float, default=10.0, help="of measuring, for each")
    given = parser.parse_args()
    use_one_thread()
    sizes = tuple(given.net_arch), given.batch_size
    contenders = {"bare matrix products": bare_products(*sizes), "RoboMoRe": ours(*sizes)}
    sbx = sbx_crossq(*sizes)
    if sbx is None:
        print("SBX is not installed here: pip install sbx-rl\n")
    else:
        contenders["SBX"] = sbx
    seconds = in_turns(contenders, given.seconds)
    print(f"One CrossQ gradient step, {given.net_arch}, batch {given.batch_size},")
    print(f"observation {OBSERVATIONS}, action {ACTIONS}, one core of {os.uname().machine}\n")
    print(f"{'':22}{'ms a step':>10}{'steps a second':>16}{'time / bare':>13}{'RoboMoRe is':>15}")
    for name, each in seconds.items():
        bare, own = seconds["bare matrix products"], seconds["RoboMoRe"]
        print(
            f"{name:22}{each * 1e3:10.3f}{1 / each:16.0f}{each / bare:13.2f}"
            f"{each / own:10.2f} x as fast"
        )


def in_turns(contenders: dict[str, Callable[[], object]], seconds: float) -> dict[str, float]:
    """Return core-seconds of a gradient step: the lower quartile over many short turns."""
    for run in contenders.values():
        run()
    found: dict[str, list[float]] = {name: [] for name in contenders}
    until = time.perf_counter() + seconds * len(contenders)
    while time.perf_counter() < until or len(found["RoboMoRe"]) < 5:
        for name, run in contenders.items():
            before = time.process_time()
            run()
            found[name].append((time.process_time() - before) / UPDATES)
    return {name: float(np.quantile(times, 0.25)) for name, times in found.items()}


def ours(net_arch: tuple[int, ...], batch: int) -> Callable[[], object]:
    """One round of learning as in training: sampling and noise included."""
    settings = settings_like_sbx(net_arch, batch)

    class Sizes:
        num_envs, observation_size, action_size = 16, OBSERVATIONS, ACTIONS

        def reset(self, seed: int) -> Any:
            return np.zeros((16, OBSERVATIONS))

    run = TrainingRun(CrossQ(settings), settings, Sizes(), seed=0)  # type: ignore[arg-type]
    for observation, action, reward, done, following in random_transitions(500):
        run.buffer.add(
            observation, action, Transition(following, reward, done, done & False, following)
        )
    return run._learn


def settings_like_sbx(net_arch: tuple[int, ...], batch: int) -> CrossQSettings:
    """Return settings of ours that are those of SBX."""
    sizes = {"net_arch": list(net_arch), "batch_size": batch, "gradient_steps": UPDATES}
    options = {**SAME, **sizes, "buffer_size": 50_000}
    found: CrossQSettings = settings_from(TrainerSettings("crossq", options))
    return found


def sbx_crossq(net_arch: tuple[int, ...], batch: int) -> Callable[[], object] | None:
    """The same through SBX, `None` where it is not installed."""
    try:
        import gymnasium
        import sbx
        from stable_baselines3.common.logger import configure
        from stable_baselines3.common.vec_env import DummyVecEnv
    except ImportError:
        return None

    class Nothing(gymnasium.Env[Any, Any]):
        observation_space = gymnasium.spaces.Box(-10, 10, (OBSERVATIONS,), np.float32)
        action_space = gymnasium.spaces.Box(-1, 1, (ACTIONS,), np.float32)

    model = sbx.CrossQ(
        "MlpPolicy",
        DummyVecEnv([Nothing] * 16),
        batch_size=batch,
        buffer_size=50_000,
        gradient_steps=UPDATES,
        policy_delay=SAME["policy_delay"],
        policy_kwargs={"net_arch": list(net_arch)},
        seed=0,
    )
    model.set_logger(configure(None, []))
    for observation, action, reward, done, following in random_transitions(500):
        model.replay_buffer.add(observation, following, action, reward, done, [{}] * 16)

    def learn() -> None:
        model.train(gradient_steps=UPDATES, batch_size=batch)
        jax.block_until_ready(model.policy.qf_state.params)

    return learn


def bare_products(net_arch: tuple[int, ...], batch: int) -> Callable[[], object]:
    """Nothing but the matrix products of `UPDATES` gradient steps, by the same compiler.

    Each product runs in a loop, one number of its result going into the next one's operand, or
    the compiler would do it but once.
    """
    policy = (OBSERVATIONS, *net_arch, 2 * ACTIONS)
    critic = (OBSERVATIONS + ACTIONS, *net_arch, 1)
    settings = settings_like_sbx(net_arch, batch)
    n = settings.n_critics
    # (critics, rows, inner, columns) of every product, and of how many gradient steps in a round.
    products: list[tuple[tuple[int, int, int, int], float]] = []
    every, delayed = UPDATES, UPDATES / settings.policy_delay
    for i, (inputs, outputs) in enumerate(pairwise(critic)):
        products.append(((n, 2 * batch, inputs, outputs), every))
        products.append(((n, inputs, 2 * batch, outputs), every))
        products.append(((n, batch, inputs, outputs), delayed))
        if i:
            products.append(((n, 2 * batch, outputs, inputs), every))
        products.append(((n, batch, outputs, inputs if i else ACTIONS), delayed))
    for i, (inputs, outputs) in enumerate(pairwise(policy)):
        products.append(((1, batch, inputs, outputs), every + delayed))
        products.append(((1, inputs, batch, outputs), delayed))
        if i:
            products.append(((1, batch, outputs, inputs), delayed))
    loops = []
    random = np.random.default_rng(0)
    for (critics, rows, inner, columns), times in products:
        left = random.standard_normal((critics, rows, inner), np.float32)
        right = random.standard_normal((critics, inner, columns), np.float32)
        loops.append((jax.jit(_repeat, static_argnums=2), left, right, round(times)))

    def run() -> None:
        for loop, left, right, times in loops:
            jax.block_until_ready(loop(left, right, times))

    return run


def _repeat(left: jax.Array, right: jax.Array, times: int) -> jax.Array:
    def once(state: tuple[jax.Array, jax.Array], _: None) -> tuple[tuple[Any, Any], None]:
        # The whole product is handed on, or only the number that is used would be computed.
        right, product = state
        right = right.at[0, 0, 0].set(product[0, 0, 0] * 1e-9)
        return (right, left @ right), None

    start = right, jnp.zeros((*left.shape[:2], right.shape[2]))
    return jax.lax.scan(once, start, None, length=times)[0][1]


def random_transitions(steps: int) -> Any:
    """Yield control steps of 16 environments."""
    random = np.random.default_rng(0)
    for _ in range(steps):
        yield (
            random.standard_normal((16, OBSERVATIONS), np.float32),
            2 * random.random((16, ACTIONS), np.float32) - 1,
            random.standard_normal(16),
            random.random(16) < 0.01,
            random.standard_normal((16, OBSERVATIONS), np.float32),
        )


if __name__ == "__main__":
    main()
