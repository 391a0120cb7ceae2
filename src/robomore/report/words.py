"""Numbers and places in words, the same in the terminal and on the page."""

from __future__ import annotations

import math

from robomore.report.metrics import Spread
from robomore.types import Place

EFFICIENCY_UNIT = "m/m³"


def number(value: float | None, digits: int = 4) -> str:
    """Return `value` with so many significant digits, thousands apart, never as 1e+04."""
    if value is None or not math.isfinite(value):
        return "-"
    if value == 0:
        return "0"
    places = digits - 1 - math.floor(math.log10(abs(value)))
    if places > 8:
        return f"{value:.{digits - 1}e}"
    rounded = round(value, places)
    return f"{rounded:,.{max(0, places)}f}"


def short(value: float) -> str:
    """Return a round number, a bound or a tick, without needless zeros."""
    return f"{value:,.6g}" if abs(value) < 1e6 else number(value)


def with_spread(measured: Spread, unit: str = "") -> str:
    """Return `mean ± std unit (n seeds)`."""
    text = number(measured.mean)
    if measured.std is not None:
        text += f" ± {number(measured.std, 2)}"
    count = len(measured.values)
    return f"{text}{' ' + unit if unit else ''} ({count} seed{'s' if count != 1 else ''})"


def duration(seconds: float) -> str:
    """Return a duration as people say it: `42 s`, `3 min 20 s`, `2 h 05 min`."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


def place_name(place: Place) -> str:
    """Return where in a run something was measured, counted from one."""
    if place.stage == "screening":
        return f"screening: morphology {place.morphology + 1} under the reference reward"
    if place.stage == "coarse":
        return f"coarse: morphology {place.morphology + 1} x reward {place.reward + 1}"
    if place.stage == "fine":
        return f"fine: branch {place.branch + 1}, cycle {place.cycle}, new {place.changed}"
    who = "human design" if place.changed == "human" else f"finalist {place.branch + 1}"
    return f"final: {who}, training seed {place.repeat}"
