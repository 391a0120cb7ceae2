"""Statistics of reward terms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from robomore.envs.term_record import TermRecord

N = 16


def steps(count: int) -> list[dict[str, Any]]:
    random = np.random.default_rng(0)
    return [{"a": random.normal(size=N), "b": 0.1 * i} for i in range(count)]


def test_all_at_once_is_one_by_one() -> None:
    together, alone = TermRecord(N), TermRecord(N)
    for terms in steps(150):
        together.add_step(terms)
        for i in range(N):
            alone.add({"a": terms["a"][i], "b": terms["b"]})
    for name, term in alone.statistics().items():
        other = together.statistics()[name]
        assert (other.low, other.high) == (term.low, term.high)
        assert other.mean == pytest.approx(term.mean, rel=1e-13)


def test_looking_does_not_change_a_bit() -> None:
    """A checkpoint on the way must not change what is reported at the end."""
    undisturbed, disturbed = TermRecord(N), TermRecord(N)
    for i, terms in enumerate(steps(300)):
        undisturbed.add_step(terms)
        disturbed.add_step(terms)
        if i % 7 == 0:
            disturbed.statistics()
        if i == 100:
            state, disturbed = disturbed.state(), TermRecord(N)
            disturbed.restore(state)
    assert disturbed.statistics() == undisturbed.statistics()


def test_what_is_no_finite_number_does_not_count() -> None:
    record = TermRecord(3)
    record.add_step({"a": np.array([1.0, np.nan, 3.0]), "never": math.nan})
    record.add_step({"a": np.array([np.inf, -np.inf, 5.0]), "never": math.nan})
    (term,) = record.statistics().values()
    assert (term.mean, term.low, term.high) == (3.0, 1.0, 5.0)


def test_names_may_change_from_step_to_step() -> None:
    record = TermRecord(2)
    for i in range(10):
        record.add_step({"even" if i % 2 == 0 else "odd": np.array([i, i + 10.0])})
    found = record.statistics()
    assert list(found) == ["even", "odd"]
    assert (found["even"].mean, found["odd"].high) == (9.0, 19.0)


def test_names_made_up_in_every_step_do_not_pile_up() -> None:
    record = TermRecord(2)
    for i in range(100):
        record.add_step({f"{i}": 1.0, i: 1.0})
    assert len(record.statistics()) == 64
