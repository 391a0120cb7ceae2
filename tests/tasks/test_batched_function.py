"""A reward's program in a namespace whose names know batches."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from both_ways import program

from robomore.envs.batched.function import BatchedFunction, batched_function
from robomore.envs.batched.run import Refused, Run
from robomore.envs.batched.value import Batched
from robomore.envs.reward_text import reward_function
from robomore.sandbox import heartbeat


def prepared(body: str, before: str = "") -> tuple[BatchedFunction, Run]:
    run = Run()
    run.width = 3
    return batched_function(reward_function(program(body, before)), run), run


def result(body: str, before: str = "") -> Any:
    function, run = prepared(body, before)
    value = Batched(np.array([1.0, 2.0, 3.0]), run)
    return function.call(object(), value, value)[0].values.tolist()


@pytest.mark.parametrize(
    "before",
    [
        "WEIGHT = 2.0\n",
        "WEIGHTS = {'a': [1.0, 2.0]}\nWEIGHT = WEIGHTS['a'][1]\n",
        "def half():\n    return WHOLE / 2\nWHOLE = 4.0\nWEIGHT = half()\n",
        "from math import sqrt\nWEIGHT = sqrt(4)\n",
        "import collections\nWEIGHT = collections.Counter('aa')['a']\n",
    ],
)
def test_what_a_module_defines_is_there(before: str) -> None:
    assert result("return WEIGHT * x_velocity, {}", before) == [2.0, 4.0, 6.0]


@pytest.mark.parametrize(
    ("body", "before"),
    [
        ("return TABLE['a'][1] * x_velocity, {}", "TABLE = {'a': (1.0, 2.0)}\n"),
        ("return LIST[1] * x_velocity, {}", "LIST = [1.0, 2.0]\n"),
        ("return ARRAY[1] * x_velocity, {}", "ARRAY = np.array([1.0, 2.0])\n"),
        ("return twice(x_velocity), {}", "def twice(x):\n    return 2 * x\n"),
        (
            "return even(2) * x_velocity, {}",
            "def even(n):\n    return 2.0 if n == 0 else odd(n - 1)\n"
            "def odd(n):\n    return even(n - 1)\n",
        ),
        ("return log(exp(2.0)) * x_velocity, {}", "from math import exp, log\n"),
        ("return norm([x_velocity, x_velocity * 3 ** 0.5]), {}", "norm = np.linalg.norm\n"),
        ("return add(x_velocity, x_velocity), {}", "from numpy import add\n"),
        ("import numpy as n\nreturn n.abs(-2.0 * x_velocity), {}", ""),
        ("from math import fabs as f\nreturn f(-2.0 * x_velocity), {}", ""),
        ("from functools import reduce\nreturn reduce(max, [x_velocity * 2, 0.0]), {}", ""),
        ("return (lambda x, w=2.0: w * x)(x_velocity), {}", ""),
        ("return sum([x_velocity for i in range(2)]), {}", ""),
        ("def inner():\n    return 2 * x_velocity\nreturn inner(), {}", ""),
    ],
)
def test_what_it_refers_to_is_there(body: str, before: str) -> None:
    assert result(body, before) == pytest.approx([2.0, 4.0, 6.0])


@pytest.mark.parametrize(
    ("body", "before", "said"),
    [
        ("global n\nn += 1\nreturn n, {}", "n = 0\n", "global variable `n`"),
        ("return random.random(), {}", "import random\n", "module `random`"),
        ("return time.time(), {}", "import time\n", "module `time`"),
        ("return random(), {}", "from random import random\n", "`random`"),
        ("return rng.normal(), {}", "rng = np.random.default_rng(0)\n", "`rng`, a Generator"),
        ("return default_rng(0).normal(), {}", "from numpy.random import default_rng\n", "rng"),
        ("return memory.x, {}", "class memory:\n    x = 1.0\n", "`memory`, a class"),
        ("return next(count), {}", "import itertools\ncount = itertools.count()\n", "`count`"),
        ("return len(seen), {}", "seen = deque()\n", "`seen`, a deque"),
    ],
)
def test_what_may_change_between_calls_is_refused(body: str, before: str, said: str) -> None:
    with pytest.raises(Refused, match=said):
        prepared(body, before)


@pytest.mark.parametrize(
    ("body", "before"),
    [
        ("SEEN.append(1)\nreturn 0.0, {}", "SEEN = []\n"),
        ("SEEN['a'] = 1\nreturn 0.0, {}", "SEEN = {}\n"),
        ("SEEN.add(1)\nreturn 0.0, {}", "SEEN = set()\n"),
        ("SEEN[0] = 1\nreturn 0.0, {}", "SEEN = np.zeros(2)\n"),
        ("_get_rew.n = 1\nreturn 0.0, {}", ""),
        ("np.n = 1\nreturn 0.0, {}", ""),
        ("return f(), {}", "def f(seen=[]):\n    seen.append(1)\n    return len(seen)\n"),
    ],
)
def test_what_is_shared_cannot_be_changed(body: str, before: str) -> None:
    function, run = prepared(body, before)
    with pytest.raises((AttributeError, TypeError, ValueError)):
        function.call(object(), Batched(np.zeros(3), run), None)


def test_only_plain_functions_are_taken() -> None:
    def around() -> Callable[..., Any]:
        seen: list[float] = []

        def reward(self: Any, x_velocity: Any, action: Any) -> Any:
            seen.append(x_velocity)
            return 0.0, {}

        return reward

    class Callables:
        def __call__(self, *arguments: Any) -> Any:
            return 0.0, {}

    with pytest.raises(Refused, match="variables of a function around it"):
        batched_function(around(), Run())
    with pytest.raises(Refused, match="something else than a function"):
        batched_function(Callables(), Run())
    decorated = program("return 0.0, {}").replace("def _get", "@wrapped\ndef _get")
    wrapping = (
        "import functools\ndef wrapped(f):\n    @functools.wraps(f)\n    def g(*a):\n"
        "        return f(*a)\n    return g\n"
    )
    with pytest.raises(Refused, match="a decorator"):
        batched_function(reward_function(wrapping + decorated), Run())


def test_calls_are_counted_for_the_watching_parent(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run for the whole batch that never returns must be seen, too."""
    marks: list[int] = []

    class Slots(list[int]):
        def __setitem__(self, index: Any, mark: Any) -> None:
            marks.append(mark)

    slots = Slots([0])
    monkeypatch.setattr(heartbeat, "_slots", slots)
    watched = heartbeat.watch(reward_function(program("return 2 * max(x_velocity, 2.0), {}")))
    run = Run()
    run.width = 2
    function = batched_function(watched, run)
    returned = function.call(object(), Batched(np.array([1.0, 3.0]), run), None)
    assert returned[0].values.tolist() == [4.0, 6.0]
    assert len(marks) == 2 and marks[0] != marks[1]


@pytest.mark.parametrize(
    ("body", "keeps", "plain"),
    [
        ("return x_velocity, {}", False, False),
        ("self.a = 1\nreturn x_velocity, {}", True, False),
        ("vars(self)['a'] = 1\nreturn x_velocity, {}", True, False),
        ("def f():\n    setattr(self, 'a', 1)\nf()\nreturn x_velocity, {}", True, False),
        ("return float(x_velocity), {}", False, True),
        ("return math.exp(x_velocity), {}", False, True),
    ],
)
def test_what_a_program_may_do_is_known_beforehand(body: str, keeps: bool, plain: bool) -> None:
    function, _ = prepared(body)
    assert (function.keeps, function.plain) == (keeps, plain)
