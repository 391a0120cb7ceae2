"""Arguments of `robomore.run` that are refused before anything starts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robomore.errors import InputError
from robomore.experiment import run
from robomore.experiment.arguments import ensure_usable


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"seed": "1"}, "the seed is '1'; give a whole number from 0 up"),
        ({"seed": -1}, "the seed is -1"),
        ({"seed": True}, "the seed is True"),
        ({"workers": 0}, "the number of workers is 0; give a whole number from 1 up"),
        ({"workers": 1.5}, "the number of workers is 1.5"),
        ({"budget_steps": "many"}, "the budget in control steps is 'many'"),
        ({"time_limit": "30m"}, "the time limit is '30m'; give a positive number, in s"),
        ({"time_limit": float("nan")}, "the time limit is nan"),
        ({"time_limit": 0}, "the time limit is 0"),
        ({"out": 5}, "the run's folder is 5"),
    ],
)
def test_a_wrong_kind_is_refused(wrong: dict[str, Any], said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as raised:
        run("swimmer", "smoke", **({"out": tmp_path / "run"} | wrong))
    assert said in str(raised.value)
    assert not (tmp_path / "run").exists()


def test_numbers_of_numpy_are_numbers() -> None:
    ensure_usable(np.int64(3), np.int32(2), np.int64(10), np.float64(0.5), "runs/one")
