"""Statistics of reward terms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from robomore.envs.term_record import TermRecord


def calls(count: int) -> list[dict[str, Any]]:
    random = np.random.default_rng(0)
    return [{"a": random.normal(), "b": 0.1 * i} for i in range(count)]


def test_mean_low_and_high_are_those_of_all_calls() -> None:
    record = TermRecord()
    for terms in calls(300):
        record.add(terms)
    values = [terms["a"] for terms in calls(300)]
    term = record.statistics()["a"]
    assert math.isclose(term.mean, math.fsum(values) / 300, abs_tol=1e-14)
    assert (term.low, term.high) == (min(values), max(values))
    assert record.sums()["a"] == (300, sum(values))


def test_looking_does_not_change_a_bit() -> None:
    """A checkpoint on the way must not change what is reported at the end."""
    undisturbed, disturbed = TermRecord(), TermRecord()
    for i, terms in enumerate(calls(300)):
        undisturbed.add(terms)
        disturbed.add(terms)
        if i % 7 == 0:
            disturbed.statistics()
        if i == 100:
            state, disturbed = disturbed.state(), TermRecord()
            disturbed.restore(state)
    assert disturbed.statistics() == undisturbed.statistics()


def test_what_is_no_finite_number_does_not_count() -> None:
    record = TermRecord()
    for value in (1.0, math.nan, np.float64(3.0), np.array([5.0]), np.inf, -np.inf, "7", None, 1j):
        record.add({"a": value, "never": math.nan, 3: 1.0})
    (term,) = record.statistics().values()
    assert (term.mean, term.low, term.high) == (3.0, 1.0, 5.0)


def test_names_may_change_from_call_to_call() -> None:
    record = TermRecord()
    for i in range(10):
        record.add({"even" if i % 2 == 0 else "odd": float(i)})
    found = record.statistics()
    assert list(found) == ["even", "odd"]
    assert (found["even"].mean, found["odd"].high) == (4.0, 9.0)


def test_names_made_up_in_every_call_do_not_pile_up() -> None:
    record = TermRecord()
    for i in range(100):
        record.add({f"{i}": 1.0, i: 1.0})
    assert len(record.statistics()) == 64


@pytest.mark.parametrize("size", [1e307, 1.7e308, 5e-324, 1e-300])
def test_statistics_of_any_finite_terms_are_finite(size: float) -> None:
    record = TermRecord()
    for i in range(1000):
        record.add({"same": size, "either": size * (-1) ** i, "one": size if i else 0.0})
    found = record.statistics()
    assert found["same"].mean == pytest.approx(size, rel=1e-12)
    assert found["either"] == type(found["either"])(0.0, -size, size)
    assert found["one"].mean <= size
    assert all(total == total for _, total in record.sums().values())


@pytest.mark.parametrize("name", ["a\nb", "# x\r", "a\x1b[2J", "a\u202eb", "a\u2028", "a\tb"])
def test_a_name_is_one_line_of_printable_characters(name: str) -> None:
    with pytest.raises(ValueError, match="is no name of a term"):
        TermRecord().add({name: 1.0})
