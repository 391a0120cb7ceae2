"""The check says what is wrong with a reward, in which line, and lets good ones pass."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robomore.rewards.check import LONGEST, Finding, check_reward
from robomore.tasks import TASKS

GOOD = '''
import numpy as np
from typing import Dict, Tuple


def _get_rew(self, x_velocity: float, action) -> Tuple[float, Dict[str, float]]:
    """Fast, upright and smooth."""
    height = self.data.qpos[2]
    upright = np.exp(-4.0 * (height - 0.6) ** 2)
    terms = {"forward": x_velocity, "upright": upright, "effort": -self.control_cost(action)}
    total = 0.0
    for name, value in terms.items():
        total += value
    if not np.isfinite(total):
        return 0.0, terms
    return total, terms
'''


def errors(source: str) -> list[Finding]:
    return [finding for finding in check_reward(source) if finding.severity == "error"]


def body(text: str) -> str:
    lines = "".join(f"    {line}\n" for line in text.splitlines())
    return f"def _get_rew(self, x_velocity, action):\n{lines}"


def test_a_good_reward_passes_without_a_word() -> None:
    assert check_reward(GOOD) == []


@pytest.mark.parametrize("task", TASKS)
def test_reference_rewards_pass(task: str) -> None:
    assert check_reward(TASKS[task].reward) == []


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("import os\nreturn 0.0, {}", 2, "cannot import `os`"),
        ("from os.path import join\nreturn 0.0, {}", 2, "cannot import `os.path`"),
        ("from . import x\nreturn 0.0, {}", 2, "cannot import"),
        ("x = 1\nopen('f')\nreturn 0.0, {}", 3, "`open`"),
        ("eval('1')\nreturn 0.0, {}", 2, "`eval`"),
        ("x = __import__('os')\nreturn 0.0, {}", 2, "`__import__`"),
        ("x = getattr(self, '__class__')\nreturn 0.0, {}", 2, "name the attribute"),
        ("x = getattr(self, 'a' + 'b')\nreturn 0.0, {}", 2, "name the attribute"),
        ("x = self.__class__\nreturn 0.0, {}", 2, "`.__class__`"),
        ("x = y.gi_frame\nreturn 0.0, {}", 2, "`.gi_frame`"),
        ("np.save('f', action)\nreturn 0.0, {}", 2, "`np.save`"),
        ("action.tofile('f')\nreturn 0.0, {}", 2, "`.tofile`"),
        ("np.ctypeslib.load_library('x', '.')\nreturn 0.0, {}", 2, "`np.ctypeslib`"),
        ("import random\nreturn 0.0, {}", 2, "`self.np_random`"),
        ("from numpy import random\nreturn 0.0, {}", 2, "`self.np_random`"),
        ("from functools import lru_cache\nreturn 0.0, {}", 2, "`functools.lru_cache`"),
        ("return float(id(self)), {}", 2, "`id` is not for rewards"),
        ("global vars\nvars = 1.0\nreturn vars, {}", 4, "`vars` is not for rewards"),
        ("class A:\n    input = input\nreturn 0.0, {}", 3, "`input` is not for rewards"),
        ("key = hash\nreturn float(key('a')), {}", 2, "`hash` is not for rewards"),
        ("return np.random.rand(), {}", 2, "draw from `self.np_random`"),
        ("draw = getattr(np, 'random').rand\nreturn draw(), {}", 2, "draw from `self.np_random`"),
        ("r = np.random\nreturn r.rand(), {}", 3, "cannot use `r.rand`"),
        ("import statistics as s\nreturn s.random.random(), {}", 3, "cannot use `s.random`"),
        ("from statistics import random\nreturn 0.0, {}", 2, "cannot use `statistics.random`"),
        ("from typing import overload\nreturn 0.0, {}", 2, "cannot use `typing.overload`"),
        (
            "np.finfo._finfo_cache[1] = 2\nreturn 0.0, {}",
            2,
            "`np.finfo._finfo_cache`: it is private",
        ),
        ("np.typecodes['x'] = 'y'\nreturn 0.0, {}", 2, "changes `np.typecodes`"),
        ("from typing import List\nx = List[int]\nx._inst = 1\nreturn 0.0, {}", 4, "`._inst`"),
        ("g = getattr\nreturn 0.0, {}", 2, "`getattr`"),
        ("x = list(map(getattr, [self], ['x']))\nreturn 0.0, {}", 2, "`getattr`"),
        (
            "import operator\nd = operator.attrgetter('__dict__')(self)\nreturn 0.0, {}",
            3,
            "`attrgetter`",
        ),
        (
            "match self:\n    case object(__dict__=d):\n        d['x'] = 1\nreturn 0.0, {}",
            3,
            "a pattern",
        ),
        ("self.np_random.bit_generator.lock.acquire()\nreturn 0.0, {}", 2, "`.bit_generator`"),
        ("np.random.seed(0)\nreturn 0.0, {}", 2, "draw from `self.np_random`"),
        ("np.seterr(all='raise')\nreturn 0.0, {}", 2, "`np.seterr`"),
        ("return float(action.ctypes.data), {}", 2, "addresses"),
        ("return self.spec.max_episode_steps, {}", 2, "`self.spec` is None"),
        ("x = getattr(self, 'spec', 1)\nreturn 0.0, {}", 2, "`self.spec` is None"),
        ("return self.training_progress, {}", 2, "`self.training_steps`"),
        ("x = getattr(self, 'training_progress', 0)\nreturn 0.0, {}", 2, "`self.training_steps`"),
        (
            "from collections import Counter as C\nC.memory = 1\nreturn 0.0, {}",
            3,
            "changes `C.memory` for everybody",
        ),
        ("import functools\nfunctools.memory = 1\nreturn 0.0, {}", 3, "changes `functools.memory`"),
        ("while True:\n    x = 1\nreturn 0.0, {}", 2, "never ends"),
        ("self.data.qpos[0] = 1.0\nreturn 0.0, {}", 2, "writes to `self.data`"),
        ("self.model.opt.gravity[2] += 1.0\nreturn 0.0, {}", 2, "writes to `self.model`"),
        ("np.sum = None\nreturn 0.0, {}", 2, "changes `np.sum`"),
        ("type(self).step = None\nreturn 0.0, {}", 2, "changes"),
        ("robot = type(self)\nrobot.count = 1\nreturn 0.0, {}", 3, "changes `robot.count`"),
        ("norm = np.linalg.norm\nf = norm\nf.count = 1\nreturn 0.0, {}", 4, "changes `f.count`"),
        ("q = self.data.qpos\nq.setflags(write=True)\nreturn 0.0, {}", 3, "`.setflags`"),
        ("from numpy import *\nreturn 0.0, {}", 2, "name what you import"),
        ("x = 1.0", 1, "returns nothing"),
        ("return x_velocity * 2.0", 2, "return a pair"),
        ("return {}, 1.0, 2.0", 2, "return a pair"),
        ("return", 2, "return a pair"),
        ("yield 0.0, {}", 1, "not yield"),
    ],
)
def test_says_what_is_wrong_and_where(text: str, line: int, words: str) -> None:
    found = errors(body(text))
    assert any(it.line == line and words in it.message for it in found), found


def test_a_local_name_of_a_builtin_is_no_use_of_it() -> None:
    kept = "def of(vars, *, input=0.0):\n    return sum(vars) + input\nid = of([1.0])\n"
    kept += "total = sum(hash for hash in action) + (lambda open: open)(id)\nreturn total, {}"
    assert not errors(body(kept))


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("def _get_rew(self, x_velocity, action)\n    return 0.0, {}", "does not parse"),
        ("def reward(self, x_velocity, action):\n    return 0.0, {}", "rename `reward` to"),
        ("def f(a): pass\ndef go(a, b, c): pass", "rename `go` to `_get_rew`"),
        ("def get_rew(a, b, c): pass\ndef norm(a, b, c): pass", "rename `get_rew` to"),
        ("def f(a, b, c): pass\ndef norm(a, b, c): pass", "define `def _get_rew"),
        ("def get_reward(self): pass", "rename `get_reward` to `_get_rew"),
        ("class A:\n    def _get_rew(self, v, a):\n        return 0.0, {}", "not inside a class"),
        ("def _get_rew(self, action):\n    return 0.0, {}", "must take (self, x_velocity, action)"),
        ("def _get_rew(self, v, a, *, w):\n    return 0.0, {}", "must take"),
        ("async def _get_rew(self, v, a):\n    return 0.0, {}", "not `async`"),
        ("@f\ndef _get_rew(self, v, a):\n    return 0.0, {}", "must not be decorated"),
        (f"{body('return 0.0, {}')}{body('return 0.0, {}')}", "defined twice"),
        ("x = 1 #" + "x" * LONGEST, "too many"),
        ("x = '\0'", "U+0000"),
        ("x = " + "(" * 5000, "does not parse"),
        ("x = " + "-" * 40_000 + "1", "does not parse"),
        ("x = 1" + "+1" * 20_000, "does not parse"),
    ],
)
def test_says_what_is_wrong_with_the_whole(source: str, words: str) -> None:
    assert any(words in finding.message for finding in errors(source))


def test_says_what_is_allowed_and_good_to_know() -> None:
    text = "print(1)\nglobal n\nself.last = np.random.default_rng(1).normal()\nself.last += 1"
    found = check_reward(body(f"{text}\nreturn 0.0, {{}}"))
    assert [(it.line, it.severity) for it in found] == [
        (2, "warning"),
        (3, "note"),
        (4, "note"),
        (4, "warning"),
    ]
    assert "for the whole training" in found[1].message
    assert "keeps `self.last` between the steps of an episode" in found[2].message


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("if self.data.time == 0:\n    self.n = 0", 2),
        ("t = float(self.data.time)\nif t <= 0.0 or not hasattr(self, 'n'):\n    self.n = 0", 3),
        ("n = 0 if 1e-9 >= self.data.time else 1", 2),
        ("if not self.data.time:\n    self.n = 0", 2),
    ],
)
def test_a_start_that_never_comes_is_noted(text: str, line: int) -> None:
    found = check_reward(body(f"{text}\nreturn 0.0, {{}}"))
    assert [it.line for it in found if "never holds" in it.message] == [line]
    assert all(it.severity == "note" for it in found)


@pytest.mark.parametrize(
    "text",
    [
        "if self.data.time > 0:\n    self.n = 0",
        "if self.data.time <= self.dt:\n    self.n = 0",
        "if self.data.time < 0.05:\n    self.n = 0",
        "t = self.data.time\nt -= 1.0\nif t == 0:\n    self.n = 0",
        "for t in self.data.qpos:\n    if t == 0:\n        self.n = 0",
    ],
)
def test_a_start_that_may_come_is_not_noted(text: str) -> None:
    found = check_reward(body(f"{text}\nreturn 0.0, {{}}"))
    assert not any("never holds" in it.message for it in found)


@pytest.mark.parametrize(
    "line",
    [
        "x = '\x1b[2J'",
        "# \u202e reversed",
        "x = 1\u2066  # isolate",
        "y = 'a\u2028b'",
        "z = '\x9b'",
        "a = 1\rb = 2",
        "b = '\ufeff'",
        "c = '\x07'",
    ],
)
def test_characters_that_steer_are_refused(line: str) -> None:
    (found,) = errors(f"s = 'Ä — ü, fine'\n{line}\n{GOOD}")
    assert found.line == 2 and "steers how text is shown" in found.message


def test_files_of_other_systems_pass() -> None:
    assert check_reward("\ufeff" + GOOD.replace("\n", "\r\n")) == []


@pytest.mark.parametrize(
    "text",
    [
        "def inner(x):\n    return x\nreturn inner(x_velocity), {}",
        "terms = {}\nreturn sum(terms.values()), terms",
        "result = (0.0, {})\nreturn result",
        "while True:\n    if x_velocity > 0:\n        break\nreturn 0.0, {}",
        "return self.shaped(x_velocity)",
        "import collections, math, functools, itertools\nreturn 0.0, {}",
        "from dataclasses import dataclass\nreturn 0.0, {}",
        "from types import SimpleNamespace\nreturn 0.0, {}",
        "class A:\n    __slots__ = ('x',)\n    def __init__(self):\n        super().__init__()\n"
        "        self.training_progress = 1\nreturn 0.0, {}",
    ],
)
def test_does_not_cry_wolf(text: str) -> None:
    assert errors(body(text)) == []


@settings(max_examples=100, deadline=None)
@given(st.text(max_size=200))
def test_never_fails_itself(source: str) -> None:
    for finding in check_reward(source):
        assert finding.line >= 1
        assert finding.message
