"""What a reward gets without noticing is told by the dry run, with its line and its numbers."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from robomore.envs.missing import names_for_rewards
from robomore.envs.reward_runner import RewardRunner
from robomore.envs.vector_env import VectorEnv
from robomore.errors import RewardFailed
from robomore.rewards.dry_run import DryRunRequest, observe
from robomore.rewards.dry_run_findings import Growth, Observed, findings
from robomore.rewards.finding import Finding
from robomore.rewards.load import load_reward
from robomore.rewards.rules import builtins_used
from robomore.rewards.silent import silent_findings
from robomore.suggestions import meant
from robomore.tasks import TASKS, get_task

TASK = get_task("swimmer")

SILENT = """
from collections import deque
H, M, D, LAST = [], {}, deque(maxlen=100), [0.0]
def _get_rew(self, x_velocity, action, seen=[], first={}):
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
    seen.append([r])
    first.setdefault("r", r)
    step(r)
    return r, {"r": r}
class Filter:
    gain, calls = 0.5, 0
smooth, TABLE = Filter(), np.arange(3.0)
def step(r):
    global total
    total = r
    Filter.calls += TABLE[1]
    smooth.last = r
    step.calls = 1
"""

USEFUL = {
    *("action_space", "contact_cost", "contact_force", "contact_forces", "contact_names"),
    *("control_cost", "data", "dt", "frame_skip", "get_body_com", "has_target", "heading"),
    *("healthy_reward", "home_angle", "init_qpos", "init_qvel", "is_healthy", "joint"),
    *("joint_names", "model", "np_random", "observation_space", "rest_height", "root_height"),
    *(
        "sensor",
        "sensor_names",
        "state_vector",
        "target_distance",
        "tilt",
        "touches",
        "training_steps",
    ),
}
"""Names without an underscore that one robot or another offers a reward."""


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
        (19, "`self.history` grows with every call until its episode ends, by 1 value a call, to "),
        (19, " to 1,000 values after 1,000 steps"),
        (3, "`H` grows with every call for the whole training, by 1 value a call (32 bytes): the"),
        (3, "the 4 GiB of an evaluation would be full after some 130,000,000 control steps"),
        (3, "`M` grows with every call for the whole training"),
        (4, "the default argument `seen` of `_get_rew` grows with every call for the whole"),
    ],
)
def test_what_is_hidden_is_told(line: int, said: str, found: list[Finding]) -> None:
    assert any(it.line == line and said in it.message for it in found)


@pytest.mark.parametrize(
    ("line", "what"),
    [
        (3, "`LAST`"),
        (3, "`D`"),
        (4, "the default argument `first` of `_get_rew`"),
        (35, "`Filter.calls`"),
        (31, "`smooth`"),
        (37, "`step.calls`"),
    ],
)
def test_what_outlives_an_episode_is_noted(line: int, what: str, found: list[Finding]) -> None:
    said = f"keeps {what} for the whole training, one in each simulation"
    assert any((it.line, it.severity) == (line, "note") and said in it.message for it in found)


def test_what_is_meant_is_not_told(found: list[Finding]) -> None:
    """Attributes that the reward sets, what never changes, and what is ignored on purpose.

    The text itself tells of `total`, which is declared `global`.
    """
    for name in ("count", "recent", "gain", "TABLE", "total"):
        assert not any(name in it.message for it in found)
    assert [it.severity for it in found] == ["warning"] * 10 + ["note"] * 6
    assert not any(it.line == 9 for it in found)


def test_what_takes_longer_with_each_call_is_told_so() -> None:
    grown = Growth(1.0, 32.0, (1e-5, 4e-5), 0)
    (slow,) = silent_findings(Observed(10, 0.0, 1.0, 1e-5, growth={"H": grown}), "H = []\n")
    assert "and each call takes longer than the one before" in slow.message
    steady = replace(grown, seconds=(1e-5, 1.1e-5))
    (told,) = silent_findings(Observed(10, 0.0, 1.0, 1e-5, growth={"H": steady}), "H = []\n")
    assert "takes longer" not in told.message and "µs" not in told.message


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
        ("self.torso_height", "no attribute 'torso_height' (line 2"),  # `height` is of pictures
        ("self.healthy_z_range", "no attribute 'healthy_z_range'; did you mean `_healthy_z_range`"),
        ("self.data.qfrc_inversed", "did you mean `qfrc_passive`?"),  # `qfrc_inverse` is refused
        ("opne('x')", "Did you mean 'None'?"),
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
        runner(
            *(np.zeros(1), np.zeros((1, env.action_size))),
            *(np.ones(1, np.bool_), np.zeros(1, np.bool_)),
        )
    assert said in str(failed.value)


@pytest.mark.parametrize("name", list(TASKS))
def test_what_may_have_been_meant_is_the_robots(name: str) -> None:
    """A new name on a robot's class is looked at here: a reward must have a use for it."""
    task = get_task(name)
    offered = set(names_for_rewards(VectorEnv(task, task.reference, 1).environment))
    public = {one for one in offered if one[0] != "_"}
    assert {"data", "model", "dt", "init_qpos", "np_random", "get_body_com"} <= public
    assert public <= USEFUL
    assert not {"_task", "_get_rew", "_reward", "_reward_calls", "_parameters"} & offered


@pytest.mark.parametrize("name", ["open", "eval", "input", "hash", "vars", "setattr"])
def test_no_refused_function_is_offered(name: str) -> None:
    assert [it.severity for it in builtins_used(ast.parse(name))] == ["error"]
    with pytest.raises(NameError) as failed:
        exec(f"{name}_")
    assert f"'{name}'" not in meant(failed.value)


def test_what_a_reward_has_is_offered() -> None:
    with pytest.raises(NameError) as failed:
        exec("lenn")
    assert meant(failed.value) == ". Did you mean 'len'?"
