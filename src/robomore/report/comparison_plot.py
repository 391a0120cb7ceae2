"""Champion and human design side by side: dots for each seed, parameters within their bounds."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robomore.report.finalists import Contestant
from robomore.report.summary import Summary
from robomore.report.svg import axis_around, element, figure, hover, text
from robomore.report.words import number, short
from robomore.tasks import Parameter

_WIDTH = 300.0


@dataclass(frozen=True, slots=True)
class ParameterRow:
    """One line of the table of parameters.

    Attributes:
        parameter: of the task.
        champion: its value; `None` while there is no champion.
        champion_at: where that stands within the bounds, in percent.
        human_at: likewise of the human value.
    """

    parameter: Parameter
    champion: float | None
    champion_at: float | None
    human_at: float


def parameter_rows(summary: Summary) -> list[ParameterRow]:
    """Return the table of parameters."""
    return [
        ParameterRow(
            parameter,
            champion=(value := _value(summary.champion, parameter.name)),
            champion_at=None if value is None else position(parameter, value),
            human_at=position(parameter, parameter.reference),
        )
        for parameter in summary.task.parameters
    ]


def position(parameter: Parameter, value: float) -> float:
    """Return where a value stands between its bounds, in percent, on the parameter's own scale."""
    low, high = parameter.low, parameter.high
    if parameter.scale == "log" and low > 0:
        low, high, value = math.log(low), math.log(high), math.log(value)
    return 100 * min(1.0, max(0.0, (value - low) / (high - low)))


def seed_dots(summary: Summary, name: str) -> str:
    """Return fitness or efficiency of both designs: a dot for each training seed, a bar the mean.

    Args:
        summary: of the run.
        name: `fitness` or `efficiency`.
    """
    shown = [
        (one, measured)
        for one in (summary.champion, summary.human)
        if one and (measured := getattr(one, name)) is not None
    ]
    if not shown:
        return ""
    values = [value for _, measured in shown for value in measured.values]
    x = axis_around([*values, 0.0], 70, _WIDTH - 12)
    height = 34.0 * len(shown) + 26
    parts = []
    for tick in x.ticks(5):
        at = x.at(tick)
        parts.append(element("line", x1=at, x2=at, y1=4, y2=height - 22, klass="grid"))
        parts.append(text(short(tick), at, height - 8, text_anchor="middle", klass="tick"))
    for row, (one, measured) in enumerate(shown):
        y = 20 + 34.0 * row
        kind = "human" if one.name == "human" else "champion"
        parts.append(text(one.name, 62, y + 4, text_anchor="end"))
        if measured.interval:
            low, high = (x.at(end) for end in measured.interval)
            parts.append(element("line", x1=low, x2=high, y1=y, y2=y, klass=f"interval {kind}"))
        mean = x.at(measured.mean)
        parts.append(element("line", x1=mean, x2=mean, y1=y - 9, y2=y + 9, klass=f"mean {kind}"))
        for evaluation in one.trained:
            value = getattr(evaluation, name)
            said = f"seed {evaluation.job.seed}: {number(value)}"
            parts.append(
                element("circle", hover(said), cx=x.at(value), cy=y, r=4, klass=f"dot {kind}")
            )
    return figure(_WIDTH, height, f"{name} for each training seed", parts)


def _value(one: Contestant | None, name: str) -> float | None:
    return one.parameters[name] if one else None
