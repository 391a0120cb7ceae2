"""Loading turns a text into a function, or says why not and in which line."""

from __future__ import annotations

import re

import numpy as np
import pytest

from robomore.errors import InvalidReward
from robomore.rewards.load import load_reward
from robomore.sandbox.explain import explain


def test_names_are_there_without_an_import(capsys: pytest.CaptureFixture[str]) -> None:
    reward = load_reward(
        "def _get_rew(self, x_velocity: Missing, action) -> Tuple:\n"
        "    print('nothing is printed')\n"
        "    return math.sqrt(np.sum(numpy.square(action))), {'v': x_velocity}\n"
    )
    assert reward(None, 2.0, np.array([3.0, 4.0])) == (5.0, {"v": 2.0})
    assert capsys.readouterr().out == ""


def test_two_rewards_share_nothing() -> None:
    text = "COUNT = []\ndef _get_rew(self, v, a):\n    COUNT.append(1)\n    return len(COUNT), {}\n"
    one, other = load_reward(text), load_reward(text)
    assert [one(None, 0.0, np.zeros(1))[0] for _ in range(3)] == [1, 2, 3]
    assert other(None, 0.0, np.zeros(1))[0] == 1


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("x = 1\ndef _get_rew(self:\n", "line 2: does not parse"),
        ("x = '\0'", "does not parse"),
        ("x = " + "(" * 5000, "does not parse"),
        ("x = 1\ny = x / 0\n", "ZeroDivisionError: division by zero (line 2: `y = x / 0`)"),
        ("raise SystemExit(3)", "SystemExit: 3"),
        ("x = 1", "defines no function"),
        ("_get_rew = 1", "defines no function"),
        ("def _get_rew(a, b):\n    return 0.0, {}", "does not take (self, x_velocity, action)"),
    ],
)
def test_says_why_not(source: str, words: str) -> None:
    with pytest.raises(InvalidReward, match=re.escape(words)):
        load_reward(source)


def test_explains_an_error_by_the_innermost_line_of_the_reward() -> None:
    reward = load_reward(
        "def helper(x):\n    return 1.0 / x\ndef _get_rew(self, v, a):\n    return helper(v), {}\n"
    )
    with pytest.raises(ZeroDivisionError) as caught:
        reward(None, 0.0, np.zeros(1))
    assert explain(caught.value) == (
        "ZeroDivisionError: float division by zero (line 2: `return 1.0 / x`)"
    )


def test_a_misspelt_function_is_named() -> None:
    reward = load_reward("def _get_rew(self, v, a):\n    return np.sqare(v), {}\n")
    with pytest.raises(AttributeError) as caught:
        reward(None, 0.0, np.zeros(1))
    assert "'sqare'. Did you mean 'square'? (line 2:" in explain(caught.value)


def test_a_misspelt_variable_is_named() -> None:
    reward = load_reward("def _get_rew(self, v, action):\n    return abs(acton), {}\n")
    with pytest.raises(NameError) as caught:
        reward(None, 0.0, np.zeros(1))
    assert "'acton' is not defined. Did you mean 'action'? (line 2:" in explain(caught.value)


def test_explains_an_error_that_cannot_describe_itself() -> None:
    class Mute(Exception):
        def __str__(self) -> str:
            raise ValueError

    assert explain(Mute()) == "Mute: (its message cannot be read)"
    assert len(explain(ValueError("x" * 10**6))) < 3_000
