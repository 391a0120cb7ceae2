"""What a reward keeps in `self`, for groups of simulations."""

from __future__ import annotations

import ast
from collections import deque
from typing import Any

import numpy as np
import pytest

from robomore.envs.batched import group as batched_group
from robomore.envs.batched import state as batched_state
from robomore.envs.batched.group import Group
from robomore.envs.batched.run import Refused, Run
from robomore.envs.batched.value import Batched

RUN = Run()


def kept(rows: list[int]) -> dict[str, Any]:
    """What simulations keep, with numbers that tell which one they are of."""
    which = np.array(rows, np.float64)
    return {
        "array": Batched(np.stack([which, which + 0.5]), RUN),
        "count": 7,
        "list": [Batched(which.copy(), RUN), 2.5, (Batched(which * 2, RUN),)],
        "nothing": None,
        "queue": deque([Batched(which.copy(), RUN)], maxlen=3),
        "table": {"a": Batched(which.astype(np.int64), RUN), 1: "text"},
        "truth": Batched(which > 2, RUN),
        "fixed": np.arange(3),
    }


def told(one: Group, row: int) -> dict[str, Any]:
    return one.at(one.rows.tolist().index(row))


def expected(row: int) -> str:
    return repr(
        {
            "array": np.array([row, row + 0.5]),
            "count": 7,
            "fixed": np.arange(3),
            "list": [np.float64(row), 2.5, (np.float64(row * 2),)],
            "nothing": None,
            "queue": deque([np.float64(row)], maxlen=3),
            "table": {"a": row, 1: "text"},
            "truth": np.bool_(row > 2),
        }
    )


def test_groups_are_parted_and_joined_without_a_trace() -> None:
    whole = batched_group.group(np.arange(6), kept(list(range(6))), RUN)
    odd, even = whole.of(np.array([1, 3, 5])), whole.of(np.array([0, 2, 4]))
    single = [even.of(np.array([i])) for i in range(3)]
    assert [repr(told(odd, row)) for row in (1, 3, 5)] == [expected(row) for row in (1, 3, 5)]
    (joined,) = batched_group.joined([single[2], odd, single[0], single[1]], RUN)
    assert joined.rows.tolist() == list(range(6))
    assert [repr(told(joined, row)) for row in range(6)] == [expected(row) for row in range(6)]
    left = batched_group.without([joined], np.array([0, 4]))
    assert [one.rows.tolist() for one in left] == [[1, 2, 3, 5]]
    assert repr(told(left[0], 3)) == expected(3)


def test_numbers_that_differ_become_one_per_simulation() -> None:
    parts = [Group(np.array([i]), {"n": n}, (("n", "number"),)) for i, n in enumerate((3, 4, 4))]
    (joined,) = batched_group.joined(parts, RUN)
    assert [joined.at(i)["n"] for i in range(3)] == [3, 4, 4]
    assert all(type(joined.at(i)["n"]) is int for i in range(3))
    (alike,) = batched_group.joined(parts[1:], RUN)
    assert alike.kept["n"] == 4


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"a": 1}, {}),
        ({"a": 1}, {"b": 1}),
        ({"a": None}, {"a": 1.0}),
        ({"a": "x"}, {"a": "y"}),
        ({"a": [1]}, {"a": [1, 2]}),
        ({"a": [1]}, {"a": (1,)}),
        ({"a": {"b": 1}}, {"a": {"c": 1}}),
        ({"a": deque([1])}, {"a": deque([1], maxlen=2)}),
        ({"a": np.zeros(2)}, {"a": np.zeros(3)}),
    ],
)
def test_what_differs_in_form_stays_apart(one: dict[str, Any], other: dict[str, Any]) -> None:
    groups = [
        batched_group.group(np.array([1]), one, RUN),
        batched_group.group(np.array([0]), other, RUN),
    ]
    assert [part.rows.tolist() for part in batched_group.joined(groups, RUN)] == [[0], [1]]
    for part in groups:
        assert ast.literal_eval(repr(part.form)) == part.form


def test_groups_survive_writing_down() -> None:
    groups = [
        batched_group.group(np.array([0, 2]), kept([0, 2]), RUN),
        batched_group.group(np.array([1]), {"a": 1.5}, RUN),
    ]
    loaded = batched_group.load(batched_group.dump(groups), RUN)
    for one, other in zip(groups, loaded, strict=True):
        assert one.rows.tolist() == other.rows.tolist()
        assert one.form == other.form
        for position in range(len(one.rows)):
            assert repr(one.at(position)) == repr(other.at(position))


def test_copies_can_be_changed() -> None:
    original = kept([1, 2])
    copy = {name: batched_state.copied(value) for name, value in original.items()}
    copy["array"][0] = 9.0
    copy["list"].append(1)
    copy["queue"].append(1)
    copy["table"]["b"] = 1
    assert repr(Group(np.array([1, 2]), original).at(0)) == repr(
        Group(np.array([1, 2]), kept([1, 2])).at(0)
    )


@pytest.mark.parametrize(
    "value", [object(), {1, 2}, iter([1]), {None: 1}, np.array([None]), [lambda: 0]]
)
def test_what_cannot_be_kept_is_refused(value: Any) -> None:
    with pytest.raises(Refused):
        batched_group.group(np.array([0]), {"a": value}, RUN)


def test_a_view_of_the_simulation_is_refused() -> None:
    values = np.zeros((2, 3))
    values.flags.writeable = False
    with pytest.raises(Refused, match="view"):
        batched_group.group(np.arange(3), {"a": Batched(values, RUN)}, RUN)
