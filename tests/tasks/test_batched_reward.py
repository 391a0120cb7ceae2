"""Rewards for the whole batch: their ways, their groups, and when they run once per simulation."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from both_ways import BothWays, assert_same_statistics, program

from robomore.envs.batched import reward as batched_reward
from robomore.envs.batched import trust as batched_trust
from robomore.envs.reward_text import reward_function
from robomore.envs.vector_env import VectorEnv
from robomore.errors import RewardFailed
from robomore.tasks import get_task

WHOLE = "the reward ran for the whole batch"

FORWARD = "return x_velocity - np.sum(np.square(action)), {'speed': x_velocity}"
BRANCHES = """
if self.data.qvel[1] > 0.0:
    rising = 1.0 + x_velocity
elif x_velocity > 0.0 and self.data.qvel[2] > 0.0:
    rising = 0.5
else:
    rising = -1.0
return rising, {'rising': rising}
"""
MEMORY = """
if not hasattr(self, 'last'):
    self.last, self.best, self.steps = np.zeros(len(action)), -1.0, 0
    self.speeds = deque(maxlen=4)
jerk = float(np.abs(action - self.last).sum())
self.last = action
self.steps += 1
self.best = max(self.best, x_velocity)
self.speeds.append(x_velocity)
terms = {'jerk': -jerk, 'record': self.best, 'mean': np.mean(self.speeds)}
return sum(terms.values()) + 0.01 * self.steps, terms
"""
REDUCTIONS = """
velocities = self.data.qvel[1:]
terms = {
    'mean': np.mean(np.abs(velocities)),
    'largest': np.max(velocities) - velocities.min(),
    'spread': np.std(action) + np.var(velocities),
    'norm': np.linalg.norm(action),
    'smooth': np.sum(np.abs(np.diff(action))),
    'any': np.any(action > 0.5) * 1.0,
    'clipped': np.clip(velocities, -1, 1).prod(),
}
return np.sum(list(terms.values())), terms
"""


def batch_of(body: str, task: str = "hopper", n: int = 8, **options: Any) -> VectorEnv:
    chosen = get_task(task)
    reward = reward_function(program(body))
    batch = VectorEnv(chosen, chosen.reference, n, reward, **options)
    batch.reset(0)
    return batch


def drive(batch: VectorEnv, steps: int, seed: int = 0) -> list[Any]:
    random = np.random.default_rng(seed)
    size = (batch.n, batch.action_size)
    return [batch.step(random.uniform(-1, 1, size)) for _ in range(steps)]


@pytest.mark.parametrize("body", [FORWARD, BRANCHES, MEMORY, REDUCTIONS])
def test_both_ways_agree_over_many_episodes(body: str) -> None:
    """Walkers that fall and begin anew in between, each at its own time."""
    together, alone = (batch_of(body, "walker", batched=batched) for batched in (True, False))
    ended = 0
    for ours, theirs in zip(drive(together, 100), drive(alone, 100), strict=True):
        np.testing.assert_allclose(ours.reward, theirs.reward, rtol=1e-9)
        np.testing.assert_array_equal(ours.observation, theirs.observation)
        ended += np.count_nonzero(ours.terminated)
    assert ended > 10
    assert_same_statistics(together.reward_statistics(), alone.reward_statistics())
    assert alone.notes() == ("the reward ran once per simulation: as was asked for",)
    parted = "after 64 control steps: its conditions part the simulations too often"
    (note,) = together.notes()
    assert note == WHOLE or (body in (BRANCHES, MEMORY) and note.endswith(parted))


def test_the_reward_is_called_once_a_step(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batched_trust, "CHECKS", 3)
    calls = np.zeros(1)
    source = program("COUNT()\nreturn x_velocity, {}")
    reward: Any = reward_function(source)

    def count() -> None:
        calls[0] += 1

    reward.__globals__["COUNT"] = count
    task = get_task("swimmer")
    batch = VectorEnv(task, task.reference, 8, reward)
    batch.reset(0)
    drive(batch, 20)
    assert calls[0] == 20 + 3 * 8
    assert batch.notes() == (WHOLE,)


def test_a_condition_parts_the_simulations_for_one_step() -> None:
    """Both parts see what was kept before the step, not what the attempt for all left behind."""
    body = """
self.count = getattr(self, 'count', 0) + 1
self.list = [*getattr(self, 'list', []), 1.0]
if self.data.qvel[0] > 0:
    self.sum = getattr(self, 'sum', 0.0) + 1.0
return self.count + 100 * len(self.list) + 10000 * getattr(self, 'sum', 0.0), {}
"""
    whole = BothWays("swimmer").run(program(body), 30)
    assert whole.note.startswith(WHOLE)


@pytest.mark.parametrize("n", [8, 16])
def test_many_parts_are_not_worth_it(n: int) -> None:
    body = "r = sum(1.0 if a > 0 else 0.0 for a in action)\nreturn r, {'r': r}"
    together, alone = (batch_of(body, "half-cheetah", n, batched=one) for one in (True, False))
    for ours, theirs in zip(drive(together, 80), drive(alone, 80), strict=True):
        assert ours.reward.tolist() == theirs.reward.tolist()
    assert "after 64 control steps: its conditions part" in together.notes()[0]
    assert_same_statistics(together.reward_statistics(), alone.reward_statistics())


def test_only_what_is_new_is_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    """A way through the reward that is taken for the first time after long is compared, too."""
    body = "return (x_velocity if self.data.time < 2.01 else 2.0 * x_velocity), {}"
    batch = batch_of(body, "swimmer")
    compared = []
    right = batched_reward.difference
    monkeypatch.setattr(
        batched_reward, "difference", lambda *args: compared.append(1) or right(*args)
    )
    counts = []
    for _ in range(100):
        drive(batch, 1)
        counts.append(len(compared))
    assert counts[31] == counts[49] == 32  # a step takes 0.04 s
    assert counts[50] == 33 and counts[-1] == 64
    assert batch.notes() == (WHOLE,)


def test_what_comes_out_different_runs_once_per_simulation() -> None:
    """Here a type tells one way from the other, which no check of the program can foresee."""
    kinds = {
        "the reward": "return (1.0 if type(x_velocity) is np.float64 else 2.0), {}",
        "the term `b`": "return 1.0, {'b': 1.0 * (type(x_velocity) is np.float64)}",
        "the term `c`": "return 1.0, {'c': None} if type(action) is np.ndarray else {'c': 1.0}",
        "`self.a`": "self.a = 1 * (type(action) is np.ndarray)\nreturn 1.0, {}",
    }
    for said, body in kinds.items():
        batch = batch_of(body)
        steps = drive(batch, 3)
        assert all(step.reward.tolist() == [1.0] * 8 for step in steps)
        (note,) = batch.notes()
        assert note == (
            f"the reward ran once per simulation: for the whole batch, {said} came out different"
        )
        for term in batch.reward_statistics().values():
            assert (term.low, term.high) == (1.0, 1.0)


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("return self.np_random.normal(), {}", "it uses random numbers (line 7:"),
        ("return np.random.rand(), {}", "it uses the module `numpy.random` (line 7:"),
        ("return float(f'{x_velocity}'), {}", "it uses a number as text"),
        ("return float(len(self.data.contact)), {}", "for the whole batch, it raised TypeError"),
        ("self.q = self.data.qpos\nreturn self.q[0], {}", "it uses a view of the simulation's"),
        ("self.q = {1, 2}\nreturn x_velocity, {}", "it uses an object of type set, kept until"),
        ("return np.unique(np.round(action)).size, {}", "a result whose shape differs"),
    ],
)
def test_what_cannot_run_for_many_runs_once_per_simulation(body: str, why: str) -> None:
    together, alone = (batch_of(body, batched=batched) for batched in (True, False))
    if "rand()" in body:
        assert why in (drive(together, 2), together.notes())[1][0]
        return
    for ours, theirs in zip(drive(together, 40), drive(alone, 40), strict=True):
        assert ours.reward.tolist() == theirs.reward.tolist()
    (note,) = together.notes()
    assert note.startswith("the reward ran once per simulation: ") and why in note


def test_it_takes_over_what_is_kept_when_it_changes_its_way() -> None:
    """In mid-episode, and in the middle of a step of which a part had run already."""
    body = (
        "self.n = getattr(self, 'n', 0) + 1\nself.a = getattr(self, 'a', 0.0 * action) + action\n"
        "if self.data.qpos[1] < {limit}:\n    return float(str(self.n + self.a.sum())), {{}}\n"
        "return self.n + self.a.sum(), {{}}"
    )
    for limit in (1.1, 1.2):
        together, alone = (
            batch_of(body.format(limit=limit), batched=batched) for batched in (True, False)
        )
        for ours, theirs in zip(drive(together, 60), drive(alone, 60), strict=True):
            np.testing.assert_allclose(ours.reward, theirs.reward, rtol=1e-12)
        assert "once per simulation after" in together.notes()[0]


@pytest.mark.parametrize("late", [0.1, 1.0])
@pytest.mark.parametrize(
    "bad",
    ["np.nan", "np.inf", "math.sqrt(-1.0 * v)", "np.zeros(2)[int(v) + 9]", "(1 / float(0 * v))"],
)
def test_a_reward_that_fails_at_some_state_says_so_as_ever(bad: str, late: float) -> None:
    """In one simulation, in a step that has been trusted for long or not."""
    body = (
        f"v = abs(x_velocity) + 1.0\nself.seen = self.data.time\n"
        f"if self.data.time > {late} and self.data.qpos[0] == self.data.qpos[0]:\n"
        f"    if self.data.qpos[3] > 0.1:\n        return x_velocity * {bad}, {{}}\n"
        "return x_velocity, {'speed': x_velocity}"
    )
    said = []
    for batched in (True, False):
        batch = batch_of(body, "swimmer", batched=batched)
        with pytest.raises(RewardFailed) as failed:
            drive(batch, 200)
        said.append(str(failed.value))
    assert said[0] == said[1]
    assert "in the state qpos = [" in said[0]


@pytest.mark.filterwarnings("ignore:invalid value")
def test_a_reward_that_was_trusted_may_still_fail() -> None:
    """Not a number from some time on, in a way through the reward that is as old as any."""
    said = []
    for batched in (True, False):
        batch = batch_of("return np.sqrt(2.01 - self.data.time), {}", "swimmer", batched=batched)
        drive(batch, 50)
        with pytest.raises(RewardFailed, match="was nan") as failed:
            drive(batch, 1)
        said.append(str(failed.value))
    assert said[0] == said[1]


def test_numbers_that_are_not_finite_on_the_way_are_left_to_each_simulation() -> None:
    """Python's own numbers raise where NumPy's go on: `1 / float(x)` is not `np.inf`."""
    body = """
try:
    speed = min(1.0 / float(round(x_velocity)), 5.0)
except ZeroDivisionError:
    speed = 7.0
return speed, {'speed': speed}
"""
    together, alone = (batch_of(body, "half-cheetah", batched=one) for one in (True, False))
    for ours, theirs in zip(drive(together, 50), drive(alone, 50), strict=True):
        assert ours.reward.tolist() == theirs.reward.tolist()
    assert "its numbers are often not finite on the way" in together.notes()[0]


def test_it_cannot_touch_the_simulation() -> None:
    for harm in (
        "self.data.qpos[0] = 9.0",
        "self.data.qpos[2:] += 9.0",
        "self.data.body('torso').xpos[:] = 9.0",
        "self.data.xfrc_applied[:] = 9.0",
        "self.data.qpos = action",
        "np.copyto(self.data.qvel, 9.0)",
        "self.init_qpos[:] = 9.0",
    ):
        batch, bare = batch_of(f"{harm}\nreturn 0.0, {{}}"), batch_of(FORWARD)
        with pytest.raises(RewardFailed):
            drive(batch, 1)
        drive(bare, 1)
        np.testing.assert_array_equal(batch.physics_state, bare.physics_state)


def test_its_action_is_its_own() -> None:
    odd = batch_of("action *= 2.0\naction[0] = 5.0\nreturn action.sum(), {}")
    plain = batch_of(FORWARD)
    for one, other in zip(drive(odd, 50), drive(plain, 50), strict=True):
        np.testing.assert_array_equal(one.observation, other.observation)
    assert odd.notes() == (WHOLE,)


@pytest.mark.parametrize(
    ("task", "body"),
    [("hopper", FORWARD), ("hopper", BRANCHES), ("hopper", MEMORY), ("ant", MEMORY)],
)
def test_continues_to_the_last_bit(task: str, body: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """While its ways are still compared, while they are trusted, and after it was given up."""
    monkeypatch.setattr(batched_trust, "RECHECK", 8)
    undisturbed, saved, restored = (batch_of(body, task) for _ in range(3))
    for steps, seed in ((20, 1), (30, 2), (30, 3)):
        for batch in (undisturbed, saved):
            drive(batch, steps, seed)
        drive(restored, 5, 9)
        file = io.BytesIO()
        np.savez(file, **saved.state())
        file.seek(0)
        with np.load(file, allow_pickle=False) as arrays:
            restored.restore(dict(arrays))
        expected = drive(undisturbed, 10, 4)
        for batch in (saved, restored):
            for ours, theirs in zip(drive(batch, 10, 4), expected, strict=True):
                assert ours.reward.tolist() == theirs.reward.tolist()
            assert batch.reward_statistics() == undisturbed.reward_statistics()
            assert batch.notes() == undisturbed.notes()
    final = undisturbed.state()
    for batch in (saved, restored):
        for name, array in batch.state().items():
            np.testing.assert_array_equal(array, final[name], err_msg=name)


def test_starting_anew_gives_the_same_numbers() -> None:
    batch = batch_of(MEMORY)
    first = drive(batch, 70)
    batch.reset(0)
    for one, other in zip(first, drive(batch, 70), strict=True):
        assert one.reward.tolist() == other.reward.tolist()


def test_few_simulations_are_no_batch() -> None:
    batch = batch_of(FORWARD, n=3)
    drive(batch, 2)
    assert batch.notes() == (
        "the reward ran once per simulation: 3 simulations are too few for a batch",
    )
