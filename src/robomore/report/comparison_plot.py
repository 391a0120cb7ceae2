"""Champion and reference design side by side: dots for each seed, parameters in their bounds."""

from __future__ import annotations

from dataclasses import dataclass

from robomore.report.svg import axis_around, element, figure, text, tip
from robomore.runs import Run
from robomore.runs.bounds import share_of_range
from robomore.runs.words import number, short
from robomore.tasks import Parameter

_WIDTH = 320.0
_LEFT = 84.0


@dataclass(frozen=True, slots=True)
class ParameterRow:
    """One line of the table of parameters.

    Attributes:
        parameter: of the task.
        champion: its value; `None` while there is no champion.
        champion_at: where that stands within the bounds, in percent.
        reference_at: likewise of the reference value.
    """

    parameter: Parameter
    champion: float | None
    champion_at: float | None
    reference_at: float


def parameter_rows(run: Run) -> list[ParameterRow]:
    """Return the table of parameters."""
    values = run.champion.parameters if run.champion else {}
    return [
        ParameterRow(
            parameter,
            champion=(value := values.get(parameter.name)),
            champion_at=None if value is None else 100 * share_of_range(parameter, value),
            reference_at=100 * share_of_range(parameter, parameter.reference),
        )
        for parameter in run.task.parameters
    ]


def seed_dots(run: Run, name: str) -> str:
    """Return a number of both designs: a dot for each training seed, a bar the mean.

    Args:
        run: with a final.
        name: `fitness`, `efficiency`, or what the run compared.
    """
    designs = [run.reference] if run.champion_role == "reference" else [run.champion, run.reference]
    shown = [(one, found) for one in designs if one and (found := one.score(name)) is not None]
    if not shown or not run.final:
        return ""
    values = [value for _, measured in shown for value in measured.values]
    x = axis_around([*values, 0.0], _LEFT, _WIDTH - 12)
    height = 34.0 * len(shown) + 26
    parts = []
    for tick in x.ticks(4):
        at = x.at(tick)
        parts.append(element("line", x1=at, x2=at, y1=4, y2=height - 22, klass="grid"))
        parts.append(text(short(tick), at, height - 8, text_anchor="middle", klass="tick"))
    for row, (one, measured) in enumerate(shown):
        y = 20 + 34.0 * row
        kind = one.name
        parts.append(text(kind, _LEFT - 8, y + 4, text_anchor="end"))
        if measured.interval:
            low, high = (x.at(end) for end in measured.interval)
            parts.append(element("line", x1=low, x2=high, y1=y, y2=y, klass=f"interval {kind}"))
        mean = x.at(measured.mean)
        parts.append(element("line", x1=mean, x2=mean, y1=y - 9, y2=y + 9, klass=f"mean {kind}"))
        for index, value in enumerate(measured.values, 1):
            dot = element("circle", cx=x.at(value), cy=y, r=4, klass=f"dot {kind}")
            parts.append(tip(f"training seed {index}: {number(value)}", dot))
    return figure(_WIDTH, height, f"{name} for each training seed", parts)
