"""Figures of a search: its grid, the best so far, and all designs by volume and fitness."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from robomore.errors import InputError
from robomore.options import settings_words
from robomore.runs import Comparison, Run
from robomore.runs.grid import grids
from robomore.runs.progress import progress
from robomore.runs.words import label, number
from robomore.visualize.canvas import CHAMPION, OTHER, REFERENCE, axes_for, matplotlib

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def heatmap(run: Run, ax: Axes | None = None, *, stage: str | None = None) -> Axes:
    """Draw a grid of morphologies (rows) and rewards (columns), log colour.

    A cell without a number stays empty; a failed one is marked `x`. What screening cut short has
    its number in brackets.

    Args:
        run: whose method has a stage that is a grid.
        ax: to draw on; a new figure by default.
        stage: name of the grid's stage; the first one by default.

    Raises:
        InputError: the run has no such grid, or Matplotlib is not installed.
    """
    found = [grid for grid in grids(run) if stage in (None, grid.stage.name)]
    if not found:
        name = f"called {stage!r} " if stage else ""
        raise InputError(
            f"{run.folder} has no stage {name}in which morphologies meet rewards; draw "
            "best_so_far, which every method has"
        )
    grid = found[0]
    ax = axes_for(ax)
    scores = np.full(grid.shape, np.nan)
    for at, cell in grid.cells.items():
        score = cell.evaluation.score(run.objective) if cell.evaluation else None
        if score is not None:
            scores[at] = score
            text = number(score, 3)
            ax.text(at[1], at[0], f"({text})" if cell.cut else text, ha="center", va="center")
        elif cell.evaluation is not None:
            ax.text(at[1], at[0], "x", ha="center", va="center", color="#b23b35")
    positive = scores[scores > 0]
    # What moved backwards has no colour on a log scale, only its number.
    norm = matplotlib("colors").LogNorm(positive.min(), positive.max()) if positive.size else None
    shown = ax.imshow(scores, norm=norm, cmap="viridis", aspect="auto", alpha=0.7)
    if ax.figure is not None:
        ax.figure.colorbar(shown, ax=ax, label=label(run.objective, run.fitness_unit))
    names = [
        "reference" if column in grid.reference_rewards else str(column + 1)
        for column in range(grid.shape[1])
    ]
    ax.set_xticks(range(grid.shape[1]), names)
    ax.set_yticks(range(grid.shape[0]), [str(row + 1) for row in range(grid.shape[0])])
    ax.set(xlabel="reward", ylabel="morphology", title=grid.stage.name)
    return ax


def best_so_far(run: Run | Comparison, ax: Axes | None = None) -> Axes:
    """Draw the best score over the control steps of training that a search has spent.

    Args:
        run: one run, with a dot for each evaluation and the reference design's level; or several,
            with a line for each.
        ax: to draw on; a new figure by default.

    Raises:
        InputError: nothing has been trained, the runs compared different things, or Matplotlib is
            not installed.
    """
    runs = [run] if isinstance(run, Run) else list(run.runs)
    compared = dict.fromkeys(label(one.objective, one.fitness_unit) for one in runs)
    if len(compared) > 1:
        raise InputError(
            f"the runs compared different things ({', '.join(compared)}), which have no axis in "
            "common; draw those of one objective"
        )
    lines = [(one, points) for one in runs if (points := progress(one))]
    if not lines:
        raise InputError("nothing has been trained yet; wait, or run it on")
    ax = axes_for(ax)
    for one, points in lines:
        manifest = one.manifest
        steps = [point.steps for point in points]
        best = [point.best for point in points]
        if isinstance(run, Run):
            dots = [point.score for point in points]
            ax.plot(steps, dots, "o", markersize=4, color=OTHER, label="evaluations")
            ax.step(steps, best, where="post", color=CHAMPION, label="best so far")
            level = one.reference.score(one.objective) if one.reference else None
            if level:
                ax.axhline(level.mean, linestyle="--", color=REFERENCE, label="reference design")
        else:
            words = [manifest.settings.method.name, f"seed {manifest.seed}"]
            words += [one.task.title] if len({r.task.title for r in runs}) > 1 else []
            words += [_settings(one)] if len(set(map(_settings, runs))) > 1 else []
            ax.step(steps, best, where="post", label=", ".join(words))
    ax.set(
        xlabel="control steps of training in the search",
        ylabel=next(iter(compared)),
    )
    ax.legend()
    return ax


def _settings(run: Run) -> str:
    return settings_words(run.manifest.preset, run.manifest.settings, run.budget_steps)


def fitness_over_volume(run: Run, ax: Axes | None = None) -> Axes:
    """Draw all designs by volume (log) and fitness, by stage; efficiency is their ratio.

    Args:
        run: of which something has been trained.
        ax: to draw on; a new figure by default.

    Raises:
        InputError: nothing has been trained, or Matplotlib is not installed.
    """
    points: dict[str, list[tuple[float, float]]] = {}
    for record in run.records:
        evaluation = record.evaluation
        if evaluation.volume and evaluation.fitness is not None:
            shown = points.setdefault(record.place.stage, [])
            shown.append((evaluation.volume, evaluation.fitness))
    if not points:
        raise InputError("nothing has been trained yet; wait, or run it on")
    ax = axes_for(ax)
    for stage, found in points.items():
        volume, fitness = zip(*found, strict=True)
        ax.scatter(volume, fitness, s=18, alpha=0.7, label=stage)
    ax.set(xscale="log", xlabel=label("volume"), ylabel=label("fitness", run.fitness_unit))
    ax.legend()
    return ax
