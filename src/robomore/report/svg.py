"""The few words of SVG that the report's figures are made of.

Colours are CSS classes of the page wherever they stand for text, lines or series, so that figures
follow its light and dark theme; every text is escaped.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

_LARGEST = 1.2
"""A picture is never shown larger than this, or its texts would outgrow the page's."""


def element(name: str, content: str = "", /, **attributes: object) -> str:
    """Return one element. Attribute names use `_` for `-`; `klass` stands for `class`.

    Args:
        name: of the element.
        content: markup inside it, already escaped.
        attributes: numbers are rounded to what a screen can show.
    """
    written = "".join(
        f' {"class" if key == "klass" else key.replace("_", "-")}="{_value(value)}"'
        for key, value in attributes.items()
        if value is not None
    )
    return f"<{name}{written}>{content}</{name}>"


def text(said: str, x: float, y: float, /, **attributes: object) -> str:
    """Return a text; `said` is escaped."""
    return element("text", escape(said), x=x, y=y, **attributes)


def tip(said: str, mark: str, /, key: str = "") -> str:
    """Return a mark that says more while a pointer rests on it, a finger taps it or keys reach it.

    The words stand below the figure (`figure` keeps the place free); `said` is escaped. A mark with
    the `key` of an evaluation opens it.
    """
    role = "button" if key else "img"
    return element("g", mark, klass="tip", role=role, aria_label=said, data_key=key or None)


def figure(width: float, height: float, title: str, parts: Sequence[str]) -> str:
    """Return a whole picture that scales with the page, with room below for what its marks say."""
    content = "".join(parts)
    marked = 'class="tip"' in content
    drawn = element(
        "svg",
        ("" if marked else element("title", escape(title))) + content,
        viewBox=f"0 0 {width:g} {height:g}",
        role="group" if marked else "img",
        aria_label=title,
        klass="figure marked" if marked else "figure",
        style=f"max-width:{_LARGEST * width:.0f}px",
    )
    if not marked:
        return drawn
    ask = _OPEN if "data-key" in content else _ASK
    return element("div", drawn + element("p", ask, klass="said"), klass="marks")


_ASK = "Point at a mark, or tap it, for its numbers."
_OPEN = "Point at a mark for its numbers; choose it to open the design."


@dataclass(frozen=True, slots=True)
class Axis:
    """Numbers along a line of pixels.

    Attributes:
        low: value at `start`.
        high: value at `end`.
        start: in pixels.
        end: in pixels.
        log: whether steps are factors.
    """

    low: float
    high: float
    start: float
    end: float
    log: bool = False

    def at(self, value: float) -> float:
        """Return where a value stands, in pixels; values beyond the ends stand at them."""
        value = min(max(value, self.low), self.high)
        low, high = self._bent(self.low), self._bent(self.high)
        share = (self._bent(value) - low) / (high - low)
        return self.start + share * (self.end - self.start)

    def ticks(self, most: int = 6) -> list[float]:
        """Return round values within the ends, `most` or a few more of them."""
        if self.log:
            found = _log_ticks(self.low, self.high)
            if len(found) >= 3:
                return found[:: math.ceil(len(found) / most)]
        step = _round_step((self.high - self.low) / most)
        first = math.ceil(self.low / step - 1e-9)
        last = math.floor(self.high / step + 1e-9)
        return [index * step for index in range(first, last + 1)]

    def _bent(self, value: float) -> float:
        return math.log10(value) if self.log else value


_BEYOND = 1e100
"""No axis goes further; what lies beyond stands at its end."""
_NOTHING = 1 / _BEYOND
"""No axis is shorter, and no logarithmic one goes lower: steps of it would be no numbers."""


def axis_around(values: Sequence[float], start: float, end: float, log: bool = False) -> Axis:
    """Return an axis that holds all values with some air; linear where `log` cannot be."""
    # The difference of larger numbers may be none.
    low, high = (min(max(end, -_BEYOND), _BEYOND) for end in (min(values), max(values)))
    if log and high > _NOTHING and low > 0:
        low = max(low, _NOTHING)
        if high < 1.2 * low:
            low, high = low / 1.2, high * 1.2
        air = (high / low) ** 0.06
        return Axis(low / air, high * air, start, end, log=True)
    if high - low <= _NOTHING:
        low, high = low - max(1.0, abs(low)) * 0.1, high + max(1.0, abs(high)) * 0.1
    air = 0.06 * (high - low)
    return Axis(low - air, high + air, start, end)


def axes(x: Axis, y: Axis, x_name: str, y_name: str) -> str:
    """Return grid lines, ticks and names of two axes; `y_name` stands above its axis."""
    parts = []
    for value in x.ticks():
        at = x.at(value)
        parts.append(
            element("line", x1=at, x2=at, y1=y.start, y2=y.end, klass="grid")
            + text(_tick(value), at, y.start + 16, text_anchor="middle", klass="tick")
        )
    for value in y.ticks():
        at = y.at(value)
        parts.append(
            element("line", x1=x.start, x2=x.end, y1=at, y2=at, klass="grid")
            + text(_tick(value), x.start - 6, at + 4, text_anchor="end", klass="tick")
        )
    parts.append(text(x_name, (x.start + x.end) / 2, y.start + 34, text_anchor="middle"))
    parts.append(text(y_name, 4, y.end - 14))
    return "".join(parts)


def _tick(value: float) -> str:
    """Return a round number that is short whatever its size: `250k`, `1.5M`."""
    for least, unit, letter in ((1e9, 1e9, "G"), (1e6, 1e6, "M"), (1e4, 1e3, "k")):
        if abs(value) >= least:
            return f"{value / unit:.6g}{letter}"
    return f"{value:,.6g}"


def _value(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else escape(str(value), quote=True)


def _round_step(least: float) -> float:
    power = 10.0 ** math.floor(math.log10(least))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= least * (1 - 1e-9))


def _log_ticks(low: float, high: float) -> list[float]:
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    steps = (1,) if high / low > 1e4 else (1, 2, 5)
    return [s * 10.0**p for p in powers for s in steps if low <= s * 10.0**p <= high]
