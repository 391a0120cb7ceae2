"""What is believed of a sandboxed process's words."""

from __future__ import annotations

import msgspec
import pytest

from robomore.evaluation.request import Training, believed
from robomore.types import Curve


def test_a_curve_is_carried_over() -> None:
    curve = Curve((16, 32), {"alpha": (None, 0.25), "term/forward": (1.5, -2.0)})
    assert believed(msgspec.json.encode(Training(32, curve=curve))).curve == curve
    assert believed(msgspec.json.encode(Training(32))).curve is None


def test_names_of_series_are_made_fit_to_be_shown() -> None:
    curve = Curve((1,), {"term/\x1b[2J": (0.0,)})
    found = believed(msgspec.json.encode(Training(1, curve=curve))).curve
    assert found is not None
    assert [name.isprintable() for name in found.series] == [True]


@pytest.mark.parametrize(
    "curve",
    [
        b'{"steps": [1, 2], "series": {"a": [0.0]}}',
        b'{"steps": [2, 1], "series": {}}',
        b'{"steps": [1], "series": {"a": [1e999]}}',
        b'{"steps": [1], "series": {"a": ["b"]}}',
        b'{"steps": [1], "series": {"a": [NaN]}}',
        b'{"steps": [1e300], "series": {}}',
        b'{"steps": [1' + b"0" * 30 + b'], "series": {}}',
        b'{"steps": [1], "series": {"' + b"x" * 101 + b'": [0.0]}}',
        b'{"steps": [' + b",".join(b"%d" % i for i in range(1, 66)) + b'], "series": {}}',
        b'{"steps": [1], "series": {'
        + b",".join(b'"term/%d": [0.0]' % i for i in range(65))
        + b"}}",
        b'{"steps": [1], "series": ' + b'{"a":' * 5_000 + b"1" + b"}" * 5_000 + b"}",
    ],
)
def test_anything_else_is_refused(curve: bytes) -> None:
    with pytest.raises(ValueError, match=r"."):
        believed(b'{"steps": 1, "curve": ' + curve + b"}")
