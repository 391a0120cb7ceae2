"""What is written down of a reward's state: text without code, and words for what cannot be kept.

That every place where state can lie survives is tested with `rewards/test_continuation.py`.
"""

from __future__ import annotations
import __future__

import json
import math
from collections import OrderedDict, deque
from dataclasses import KW_ONLY
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robomore.envs.reward_objects import FixedObjects
from robomore.envs.reward_program import RewardProgram
from robomore.envs.reward_restore import load
from robomore.envs.reward_state import UnsavedStateError, dump


def written(**kept: Any) -> bytes:
    return dump(None, FixedObjects(None), kept, {})


def read(text: bytes) -> dict[str, Any]:
    return load(text, None, FixedObjects(None), {})


def test_values_come_back_exactly() -> None:
    kept = {
        "number": 0.1 + 0.2,
        "infinite": float("inf"),
        "whole": 7,
        "huge": -(7**900),
        "no": None,
        "yes": True,
        "text": "é\ud800\n",
        "bytes": b"\0\xff",
        "complex": 1 - 2j,
        "array": np.arange(6.0).reshape(2, 3)[:, ::-1],
        "columns": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        "nothing": np.zeros((0, 3)),
        "scalar": np.float32(0.1),
        "type": np.dtype(np.int8),
        "list": [1, (2.5, [3])],
        "dict": {1: "a", ("b", 2): [np.array([True])]},
        "queue": deque([1.0, 2.0], maxlen=3),
        "slice": slice(1, None),
        "function": np.linalg.norm,
    }
    loaded = read(written(**kept))
    assert repr(loaded) == repr(dict(sorted(kept.items())))
    assert loaded["array"].flags.writeable and loaded["columns"].flags.f_contiguous


ATOMS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(),
    st.binary(),
    st.complex_numbers(),
    st.sampled_from([np.float32(0.5), np.int8(3), np.bool_(True), np.datetime64(5, "s"), math.sin]),
)
KEYS = st.one_of(st.none(), st.booleans(), st.integers(), st.text(), st.tuples(st.integers()))
VALUES = st.recursive(
    ATOMS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4),
        st.lists(inner, max_size=4).map(tuple),
        st.lists(inner, max_size=4).map(lambda items: deque(items, maxlen=9)),
        st.dictionaries(KEYS, inner, max_size=4),
        st.dictionaries(KEYS, inner, max_size=4).map(OrderedDict),
        st.lists(st.floats(), max_size=4).map(np.array),
        st.builds(lambda value: SimpleNamespace(it=value), inner),
    ),
    max_leaves=20,
)


@settings(max_examples=60, deadline=None)
@given(VALUES)
def test_any_value_comes_back(value: Any) -> None:
    text = written(it=value)
    back = read(text)["it"]
    assert repr(back) == repr(value)
    assert written(it=back) == text


@pytest.mark.parametrize(
    "nan", [float("nan"), math.nan, np.nan, -np.float32("nan"), complex("nan+2j"), -float("nan")]
)
def test_a_nan_is_the_same_object_again(nan: complex) -> None:
    loaded = read(written(a=nan, b=[nan], c={"x": (nan,)}, other=float("nan")))
    assert type(loaded["a"]) is type(nan) and loaded["a"] != loaded["a"]
    assert loaded["a"] in loaded["b"] and loaded["a"] in loaded["c"]["x"]
    assert loaded["other"] not in loaded["b"]
    assert np.asarray(loaded["a"]).tobytes() == np.asarray(nan).tobytes()
    for named in (math.nan, np.nan):
        assert (loaded["a"] is named) == (nan is named)


def test_what_is_shared_is_shared_again() -> None:
    inner = [0.0]
    memory = np.zeros(4)
    loaded = read(written(a=inner, b={"x": inner}, m=memory, v=memory[1:]))
    assert loaded["a"] is loaded["b"]["x"]
    loaded["v"][0] = 3.0
    assert loaded["m"][1] == 3.0


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (ValueError(), "an object of type ValueError"),
        ({1}, "a set, whose order"),
        (np.array([None]), "an array of object"),
        (np.zeros(1, [("a", int)]), "an array of"),
        ((i for i in "ab"), "a generator"),
        (iter([1]), "an iterator"),
        (lambda: 0, "a function that is not of this reward"),
        (np.linalg.norm, "no error"),
        (KW_ONLY, "no error"),
        (__future__.annotations, "no error"),
    ],
)
def test_what_cannot_be_kept_is_named(value: Any, said: str) -> None:
    if said == "no error":
        assert read(written(thing=value))["thing"] is value
        return
    with pytest.raises(UnsavedStateError, match=r"self\.thing") as failed:
        written(thing=[value])
    assert said in str(failed.value)


def test_nothing_is_nested_too_deeply() -> None:
    chain: list[Any] = []
    for _ in range(100_000):
        chain = [chain]
    with pytest.raises(UnsavedStateError, match="nested too deeply"):
        written(chain=chain)


def test_a_checkpoint_holds_no_code() -> None:
    program = RewardProgram("import math\nF = [math.sin, len, lambda: 1]\ndef _get_rew(s, v, a): 0")
    instance = program.instance()
    text = dump(instance, FixedObjects(instance), {}, {})
    assert json.loads(text)["module"]["F"][0] == "node"
    for name in ("os:system", "subprocess:Popen"):
        changed = text.replace(b"math:sin", name.encode())
        fresh = program.instance()
        load(
            changed, fresh, FixedObjects(fresh), {}
        )  # names what is loaded already, imports nothing
        assert callable(fresh.namespace["F"][1])
