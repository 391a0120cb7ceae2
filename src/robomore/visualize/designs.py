"""Figures of what was found: the pairs of the final, learning curves, and parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from robomore.errors import InputError
from robomore.runs import Run
from robomore.runs.bounds import share_of_range
from robomore.runs.words import label
from robomore.visualize.canvas import CHAMPION, OTHER, REFERENCE, axes_for

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def pairs(run: Run, ax: Axes | None = None) -> Axes:
    """Draw the pairs of the final: a bar at the mean, a dot for each training seed.

    The pairs are found and reference morphology under found and reference reward. A line spans the
    95 % interval of a mean with seeds enough for one.

    Args:
        run: that is finished, and found something.
        ax: to draw on; a new figure by default.

    Raises:
        InputError: the run has no pairs to compare, or Matplotlib is not installed.
    """
    if run.pairs is None:
        raise InputError(f"{run.folder} has no pairs to compare: its final is not done, or has one")
    ax = axes_for(ax)
    names: list[str] = []
    for morphology, row in zip(run.pairs.morphologies, run.pairs.cells, strict=True):
        for reward, cell in zip(run.pairs.rewards, row, strict=True):
            at = len(names)
            names.append(f"{morphology}\n{reward}")
            score = cell.score(run.objective)
            if score is None:
                continue
            colour = CHAMPION if cell.name == run.champion_role else OTHER
            if cell.name == "reference":
                colour = REFERENCE
            ax.bar(at, score.mean, color=colour, alpha=0.5)
            spread = np.linspace(-0.12, 0.12, len(score.values)) if len(score.values) > 1 else [0.0]
            ax.scatter([at + x for x in spread], score.values, s=14, color=colour)
            if score.interval:
                ax.plot([at, at], score.interval, color="black", linewidth=1.5)
    ax.set_xticks(range(len(names)), names, fontsize="small")
    ax.set(ylabel=label(run.objective, run.fitness_unit))
    return ax


def learning_curve(
    run: Run, key: str | None = None, ax: Axes | None = None, *, series: str = "episode_return"
) -> Axes:
    """Draw how trainings went, over control steps.

    Args:
        run: that the trainings are of.
        key: of one evaluation, or its beginning; every training seed of the champion by default.
        ax: to draw on; a new figure by default.
        series: which number: `episode_return`, `episode_length`, `term/NAME`, `loss/NAME`, `alpha`.

    Raises:
        InputError: there is no such evaluation or number, or Matplotlib is not installed.
    """
    if key is not None:
        keys = [run.evaluation(key).key]
    else:
        keys = [e.key for e in run.champion.evaluations] if run.champion else []
    curves = [curve for one in keys if (curve := run.curve(one))]
    known = sorted({name for curve in curves for name in curve.series})
    if series not in known:
        raise InputError(
            f"no curve of {series!r} was kept; there is {', '.join(known) or 'none at all'}"
        )
    ax = axes_for(ax)
    for number, curve in enumerate(curves, 1):
        values = [np.nan if v is None else v for v in curve.series.get(series, ())]
        ax.plot(curve.steps[: len(values)], values, color=CHAMPION, label=f"training seed {number}")
    ax.set(xlabel="control steps of training", ylabel=series.replace("_", " "))
    return ax


def parameters(run: Run, ax: Axes | None = None) -> Axes:
    """Draw where champion and reference stand between the bounds of each parameter.

    0 is the lower and 1 the upper bound; a parameter that spans decades is placed by its logarithm.

    Args:
        run: of which something has been trained.
        ax: to draw on; a new figure by default.

    Raises:
        InputError: nothing has been trained, or Matplotlib is not installed.
    """
    if run.champion is None:
        raise InputError("nothing has been trained yet; wait, or run it on")
    ax = axes_for(ax)
    rows = range(len(run.task.parameters))
    for name, colour, values in (
        ("reference", REFERENCE, dict(zip(run.task.names, run.task.reference, strict=True))),
        (run.champion.name, CHAMPION, run.champion.parameters),
    ):
        shares = [share_of_range(p, values[p.name]) for p in run.task.parameters]
        ax.plot(shares, rows, "o", color=colour, label=name)
    ax.set_yticks(rows, run.task.names)
    ax.invert_yaxis()
    ax.set(xlim=(-0.02, 1.02), xlabel="position between the bounds")
    ax.legend()
    return ax
