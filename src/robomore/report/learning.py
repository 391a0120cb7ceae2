"""How trainings went: returns of champion and reference, and the champion's reward terms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from robomore.report.plots import BOTTOM, LEFT, RIGHT, TOP, WIDTH
from robomore.report.svg import axes, axis_around, element, figure, tip
from robomore.runs import Run
from robomore.types import Curve

_HEIGHT = 220.0
_COLOURS = 6
"""Terms with a colour of their own; more of them share these."""

_RETURN, _TERM = "episode_return", "term/"


@dataclass(frozen=True, slots=True)
class Panel:
    """One figure of the page.

    Attributes:
        title: above it.
        drawn: as SVG.
        legend: (class of a line, its name); empty where the title says all.
    """

    title: str
    drawn: str
    legend: tuple[tuple[str, str], ...] = ()


def learning_curves(run: Run) -> list[Panel]:
    """Return the figures that there are curves for."""
    champion, reference = run.champion, run.reference
    curves = run.curves()
    panels = []
    groups = [(reference, "reference", "reference design")]
    if champion and run.champion_role != "reference":
        groups = [(champion, "champion", champion.name), *groups]
    for one, kind, name in groups:
        lines = [
            (f"training seed {number}", f"curve {kind}", curve, _RETURN)
            for number, evaluation in enumerate(one.evaluations if one else (), 1)
            if (curve := curves.get(evaluation.key))
        ]
        if drawn := _drawn(lines, "episode return"):
            panels.append(Panel(f"{name.capitalize()}: return of its own reward", drawn))
    if champion and champion.trained:
        curve = curves.get(champion.best(run.objective).key)
        terms = [name for name in (curve.series if curve else {}) if name.startswith(_TERM)]
        lines = [
            (name.removeprefix(_TERM), f"curve term-{index % _COLOURS}", curve, name)
            for index, name in enumerate(terms)
            if curve
        ]
        if drawn := _drawn(lines, "mean for each control step"):
            legend = tuple((kind.split()[-1], name) for name, kind, _, _ in lines)
            panels.append(Panel(f"{groups[0][2].capitalize()}: its reward terms", drawn, legend))
    return panels


def _drawn(lines: Sequence[tuple[str, str, Curve, str]], y_name: str) -> str:
    """Return a figure of lines, each (name, class, curve, series); empty without any value."""
    shown = [
        (name, kind, points)
        for name, kind, curve, series in lines
        if (
            points := [
                (step, value)
                for step, value in zip(curve.steps, curve.series.get(series, ()), strict=False)
                if value is not None
            ]
        )
    ]
    if not shown:
        return ""
    every = [point for _, _, points in shown for point in points]
    x = axis_around([0.0, *(float(step) for step, _ in every)], LEFT, WIDTH - RIGHT)
    y = axis_around([value for _, value in every], _HEIGHT - BOTTOM, TOP)
    parts = [axes(x, y, "control steps of training", y_name)]
    for name, kind, points in shown:
        places = [(x.at(step), y.at(value)) for step, value in points]
        path = "L".join(f"{across:.1f} {down:.1f}" for across, down in places)
        mark = element("path", d=f"M{path}", klass=kind)
        if len(places) == 1:  # A path of one point draws nothing.
            ((across, down),) = places
            mark = element("circle", cx=across, cy=down, r=2, klass=kind)
        parts.append(tip(name, mark))
    return figure(WIDTH, _HEIGHT, f"{y_name} over training", parts)
