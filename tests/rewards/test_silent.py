"""What a reward gets without noticing is told by the dry run, with its line and its numbers."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from robomore.envs.reward_runner import RewardRunner
from robomore.envs.vector_env import VectorEnv
from robomore.errors import RewardFailed
from robomore.rewards.dry_run import DryRunRequest, observe
from robomore.rewards.dry_run_findings import Observed, findings
from robomore.rewards.finding import Finding
from robomore.rewards.load import load_reward
from robomore.rewards.silent import silent_findings
from robomore.tasks import get_task

TASK = get_task("swimmer")

SILENT = """
from collections import deque
H, M, D, LAST = [], {}, deque(maxlen=100), [0.0]
def _get_rew(self, x_velocity, action):
    r = float(x_velocity)
    r += 1e-9 * np.nan_to_num(r / np.float64(0), posinf=1.0, neginf=-1.0)
    r += np.nan_to_num(np.log(x_velocity))
    with np.errstate(divide="ignore"):
        r += 0 * np.nan_to_num(np.float64(1) / 0, posinf=0.0)
    r += getattr(self, "init_qpoz", [1.0])[0]
    if hasattr(self.data, "qvels"):
        r += 1
    try:
        r += self.model.body_masses[1]
    except AttributeError:
        r += 1
    r += getattr(self, "frobnicated", 0.0)
    self.count = getattr(self, "count", 0.0) + 1
    self.history = getattr(self, "history", []) + [r]
    self.recent = (getattr(self, "recent", []) + [r])[-100:]
    H.append(r)
    M[float(self.data.time)] = r
    D.append(r)
    LAST[0] = r
    return r, {"r": r}
"""


def observed(source: str) -> Observed:
    request = msgspec.json.encode(DryRunRequest(TASK.id, (TASK.reference,), source))
    return msgspec.json.decode(observe(request, Path(), lambda done: None), type=Observed)


@pytest.fixture(scope="module")
def found() -> list[Finding]:
    with np.errstate(all="ignore"):
        return silent_findings(observed(SILENT), SILENT)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (6, "divide by zero in 200 of 200 calls; `np.nan_to_num` gives 0 for NaN and 1.8e+308"),
        (7, "invalid value in "),
        (10, "there is no `self.init_qpoz`: `getattr` gives its default"),
        (10, "did you mean `init_qpos`?"),
        (11, "there is no `self.data.qvels`"),
        (14, "there is no `self.model.body_masses`"),
        (17, "there is no `self.frobnicated`"),
        (19, "`self.history` grows with every call for its episode: it held "),
        (3, "`H` grows with every call for the whole training: it held 551 values after 550 calls"),
        (3, "`M` grows with every call for the whole training"),
    ],
)
def test_what_is_hidden_is_told(line: int, said: str, found: list[Finding]) -> None:
    assert any(it.line == line and said in it.message for it in found)
    assert all(it.severity == "warning" for it in found)


def test_what_is_meant_is_not_told(found: list[Finding]) -> None:
    """Attributes that the reward sets, what is bounded, and what is ignored on purpose."""
    for name in ("count", "recent", "`D`", "LAST"):
        assert not any(name in it.message for it in found)
    assert len(found) == 9
    assert not any(it.line == 9 for it in found)


def test_a_guarded_division_is_only_noted() -> None:
    hidden = Observed(10, 0.0, 1.0, 1e-5, hidden={"2 divide by zero": 3})
    (found,) = silent_findings(hidden, "x = 1\ny = np.where(x > 0, 1 / x, 0)\n")
    assert (found.line, found.severity) == (2, "note")
    assert "divide by zero in 3 of 10 calls" in found.message


def test_the_largest_numbers_have_a_median() -> None:
    source = (
        "def _get_rew(self, x_velocity, action):\n"
        "    r = np.nan_to_num(x_velocity / (self.data.time - self.data.time))\n"
        "    return r, {'r': r}\n"
    )
    with np.errstate(all="ignore"):
        (size, *_) = findings(observed(source), source)
    assert "e+308" in size.message and "too large to learn from" in size.message


@pytest.mark.parametrize(
    ("expression", "said"),
    [
        ("self.healthy_rewad", "no attribute 'healthy_rewad'; did you mean `healthy_reward`?"),
        ("self.data.qpoz[0]", "no attribute 'qpoz'; did you mean `qpos`?"),
        ("self.model.opt.timestepp", "did you mean `timestep`?"),
        ("self.zzzzzz", "no attribute 'zzzzzz' (line 2"),
    ],
)
def test_an_error_names_what_was_probably_meant(expression: str, said: str) -> None:
    source = f"def _get_rew(self, x_velocity, action):\n    return {expression}, {{}}\n"
    task = get_task("ant")
    env = VectorEnv(task, task.reference, 1)
    runner = RewardRunner(
        load_reward(source), env.environment, env.data, [np.random.default_rng(0)], lambda at: None
    )
    with pytest.raises(RewardFailed) as failed:
        runner(np.zeros(1), np.zeros((1, env.action_size)), np.ones(1, np.bool_))
    assert said in str(failed.value)
