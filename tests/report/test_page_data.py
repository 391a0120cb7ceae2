"""Numbers of a page, also those of somebody else's folder."""

from __future__ import annotations

import numpy as np
import pytest

from robomore.report.page_data import _curve
from robomore.types import Curve


@pytest.mark.parametrize("values", [(1e308, -1e308), (1e308, 1e308, None), (0.0, 5e-324)])
def test_a_curve_of_any_numbers_is_scaled(values: tuple[float | None, ...]) -> None:
    found = _curve(Curve(tuple(range(len(values))), {"x": values}))
    assert found is not None
    series = found["series"]["x"]
    assert np.isfinite([series["low"], series["step"]]).all()
    assert (series["at"] == 65_535).tolist() == [value is None for value in values]
