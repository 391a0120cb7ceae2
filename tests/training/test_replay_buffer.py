"""The replay buffer, against rows that are computed one by one."""

from __future__ import annotations

import numpy as np
import pytest

from robomore.training.replay_buffer import ReplayBuffer
from robomore.training.trainer import Transition

NUM_ENVS, GAMMA = 3, 0.5


def filled(
    capacity: int, controls: int
) -> tuple[ReplayBuffer, list[list[tuple[float, bool, bool]]]]:
    """Return a buffer, and what each environment lived through: reward, terminated, truncated.

    An observation is (environment, control step), the one after it has half a step more.
    """
    random = np.random.default_rng(1)
    buffer = ReplayBuffer(capacity, 2, 1, NUM_ENVS)
    lives: list[list[tuple[float, bool, bool]]] = [[] for _ in range(NUM_ENVS)]
    for step in range(controls):
        reward = random.normal(size=NUM_ENVS).astype(np.float32).astype(np.float64)
        terminated, truncated = random.random((2, NUM_ENVS)) < 0.15
        seen = np.stack([np.arange(NUM_ENVS), np.full(NUM_ENVS, step)], axis=1).astype(float)
        after = seen + np.array([0, 0.5])
        buffer.add(
            seen,
            np.zeros((NUM_ENVS, 1)),
            Transition(seen, reward, terminated, truncated, after),
        )
        for i, life in enumerate(lives):
            life.append((float(reward[i]), bool(terminated[i]), bool(truncated[i])))
    return buffer, lives


@pytest.mark.parametrize("steps", [1, 2, 3, 5])
@pytest.mark.parametrize(("capacity", "controls"), [(600, 40), (60, 20), (60, 47), (50, 47)])
def test_rows_over_several_steps(capacity: int, controls: int, steps: int) -> None:
    buffer, lives = filled(capacity, controls)
    rows = buffer.sample(np.random.default_rng(2), (4, 500), GAMMA, steps)
    assert rows.shape == (4, 500, 7)
    assert len({tuple(row[:2]) for row in rows.reshape(-1, 7)}) == buffer.size
    for env, start, _, other, after, reward, future in rows.reshape(-1, 7).tolist():
        life = lives[int(env)]
        total, step = 0.0, int(start)
        for count in range(steps):
            worth, terminated, truncated = life[step]
            total += GAMMA**count * worth
            if terminated or truncated or step == controls - 1 or count == steps - 1:
                break
            step += 1
        assert (other, after) == (env, step + 0.5)
        assert reward == pytest.approx(total, abs=1e-6)
        assert future == pytest.approx(0 if terminated else GAMMA ** (count + 1))
