"""Figures of studies: arms side by side, from numbers that a study has put together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from robomore.visualize.canvas import CHAMPION, axes_for

if TYPE_CHECKING:
    from matplotlib.axes import Axes


COLOURS = 10
"""Colours of Matplotlib's usual cycle."""
STYLES = ("-", "--", ":")
"""Of lines, so that those of one colour differ."""


def curves(
    lines: Mapping[str, Sequence[tuple[float, float]]],
    ends: Mapping[str, float],
    name: str,
    left_out: str = "",
    ax: Axes | None = None,
) -> Axes:
    """Draw the best so far of each arm over the training it has spent.

    Args:
        lines: (control steps, best so far measured again) of each arm, the mean of its runs.
        ends: what each arm's answers were worth when they were trained anew; drawn as a point at
            the end, since the best of many noisy numbers is too good to be true.
        name: of the numbers, with their unit.
        left_out: which runs are in no line, in words.
        ax: to draw on; new axes by default.
    """
    ax = axes_for(ax)
    if left_out:
        ax.set_title(left_out, fontsize="small", loc="left", wrap=True)
    for number, (arm, line) in enumerate(lines.items()):
        steps, best = zip(*line, strict=True)
        style = STYLES[number // COLOURS % len(STYLES)]
        (drawn,) = ax.step(steps, best, style, where="post", label=arm)
        if arm in ends:
            ax.plot(steps[-1], ends[arm], "o", color=drawn.get_color())
    positive = [value for line in lines.values() for _, value in line]
    if min([*positive, *ends.values()]) > 0:
        ax.set_yscale("log")
    ax.set(
        xlabel="control steps of training in the search (point: trained anew by the final)",
        ylabel=f"best so far, measured again: {name}",
    )
    ax.locator_params(axis="x", nbins=5)
    # Beside the axes, so that it hides no line.
    ax.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    return ax


def intervals(
    shown: Mapping[str, tuple[float, tuple[float, float] | None]],
    name: str,
    base: str,
    ax: Axes | None = None,
) -> Axes:
    """Draw a point for each arm, and a line for its interval.

    Args:
        shown: point and interval of each arm; no interval where there are too few runs for one.
        name: of the numbers.
        base: what the line at 1 stands for.
        ax: to draw on; new axes by default.
    """
    ax = axes_for(ax)
    for row, (point, interval) in enumerate(shown.values()):
        if interval:
            ax.plot(interval, [row, row], color=CHAMPION, alpha=0.5, linewidth=4)
        ax.plot(point, row, "o", color=CHAMPION)
    ax.set_yticks(range(len(shown)), list(shown))
    ax.invert_yaxis()
    ax.axvline(1, color="black", linewidth=0.8, linestyle="--", label=base)
    ax.set(xlabel=name)
    ax.legend(fontsize="small")
    return ax


def by_task(
    lines: Mapping[str, Mapping[str, Sequence[float]]], name: str, ax: Axes | None = None
) -> Axes:
    """Draw what each design is worth in each task: a line through the means, and each run's point.

    Args:
        lines: for each design, its runs' numbers by task.
        name: of the numbers, with their unit.
        ax: to draw on; new axes by default.
    """
    ax = axes_for(ax)
    tasks = list(dict.fromkeys(task for line in lines.values() for task in line))
    for design, line in lines.items():
        places = [tasks.index(task) for task in line]
        means = [sum(values) / len(values) for values in line.values()]
        (drawn,) = ax.plot(places, means, "o-", label=design)
        for place, values in zip(places, line.values(), strict=True):
            ax.plot([place] * len(values), values, ".", color=drawn.get_color(), alpha=0.5)
    if min(value for line in lines.values() for values in line.values() for value in values) > 0:
        ax.set_yscale("log")
    ax.set_xticks(range(len(tasks)), tasks, rotation=20, ha="right")
    ax.set(ylabel=name)
    ax.legend(fontsize="small")
    return ax


def episodes(lines: Mapping[str, Sequence[float]], name: str, ax: Axes | None = None) -> Axes:
    """Draw the fitness of each episode, one after the other, and a line for each case.

    Args:
        lines: fitness of each episode, by case.
        name: of the numbers, with their unit.
        ax: to draw on; new axes by default.
    """
    ax = axes_for(ax)
    for case, values in lines.items():
        ax.plot(range(1, len(values) + 1), values, ".-", linewidth=0.8, label=case)
    ax.set(xlabel="episode", ylabel=name)
    ax.legend(fontsize="small")
    return ax
