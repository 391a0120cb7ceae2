"""The replay memory, against rows that are computed one by one."""

from __future__ import annotations

import numpy as np
import pytest

from robomore.training.replay import Replay
from robomore.training.trainer import Transition

SIMULATIONS, DISCOUNT = 3, 0.5


def filled(capacity: int, controls: int) -> tuple[Replay, list[list[tuple[float, bool, bool]]]]:
    """Return a memory, and what each simulation lived through: reward, terminated, truncated.

    An observation is (simulation, control step), the one after it has half a step more.
    """
    random = np.random.default_rng(1)
    replay = Replay(capacity, 2, 1, SIMULATIONS)
    lives: list[list[tuple[float, bool, bool]]] = [[] for _ in range(SIMULATIONS)]
    for step in range(controls):
        reward = random.normal(size=SIMULATIONS).astype(np.float32).astype(np.float64)
        terminated, truncated = random.random((2, SIMULATIONS)) < 0.15
        seen = np.stack([np.arange(SIMULATIONS), np.full(SIMULATIONS, step)], axis=1).astype(float)
        after = seen + np.array([0, 0.5])
        replay.add(
            seen,
            np.zeros((SIMULATIONS, 1)),
            Transition(seen, reward, terminated, truncated, after),
        )
        for i, life in enumerate(lives):
            life.append((float(reward[i]), bool(terminated[i]), bool(truncated[i])))
    return replay, lives


@pytest.mark.parametrize("steps", [1, 2, 3, 5])
@pytest.mark.parametrize(("capacity", "controls"), [(600, 40), (60, 20), (60, 47), (50, 47)])
def test_rows_over_several_steps(capacity: int, controls: int, steps: int) -> None:
    replay, lives = filled(capacity, controls)
    rows = replay.sample(np.random.default_rng(2), (4, 500), DISCOUNT, steps)
    assert rows.shape == (4, 500, 7)
    assert len({tuple(row[:2]) for row in rows.reshape(-1, 7)}) == replay.size
    for simulation, start, _, other, after, reward, future in rows.reshape(-1, 7).tolist():
        life = lives[int(simulation)]
        total, step = 0.0, int(start)
        for count in range(steps):
            worth, terminated, truncated = life[step]
            total += DISCOUNT**count * worth
            if terminated or truncated or step == controls - 1 or count == steps - 1:
                break
            step += 1
        assert (other, after) == (simulation, step + 0.5)
        assert reward == pytest.approx(total, abs=1e-6)
        assert future == pytest.approx(0 if terminated else DISCOUNT ** (count + 1))
