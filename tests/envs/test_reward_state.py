"""What a reward keeps in `self` survives a checkpoint."""

from __future__ import annotations

from collections import deque

import numpy as np
import pytest

from robomore.envs import reward_state


def test_state_survives_writing_down() -> None:
    kept = {
        "number": 0.1 + 0.2,
        "infinite": float("inf"),
        "whole": 7,
        "no": None,
        "yes": True,
        "text": "é",
        "array": np.arange(6.0).reshape(2, 3)[:, ::-1],
        "scalar": np.float32(0.1),
        "list": [1, (2.5, {3})],
        "dict": {1: "a", ("b", 2): [np.array([True])]},
        "queue": deque([1.0, 2.0], maxlen=3),
    }
    loaded = reward_state.load(reward_state.dump(kept))
    assert repr(loaded) == repr(kept)
    assert loaded["array"].flags.writeable
    with pytest.raises(TypeError, match=r"self\.thing"):
        reward_state.dump({"thing": object()})
    with pytest.raises(TypeError, match=r"self\.objects"):
        reward_state.dump({"objects": np.array([None])})
