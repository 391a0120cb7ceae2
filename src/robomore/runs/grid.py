"""A stage whose evaluations are pairs of morphologies and rewards, cell by cell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from robomore.errors import RunFolderError
from robomore.plan import Stage
from robomore.runs.empty import lines_without
from robomore.types import Evaluation

if TYPE_CHECKING:
    from robomore.runs.run import Run

_MOST_CELLS = 50_000
"""That are drawn: some 200 bytes of a page each."""


@dataclass(frozen=True, slots=True)
class Cell:
    """One pair.

    Attributes:
        evaluation: what was measured, if anything was.
        cut: whether screening cut its training short.
        reason: why nothing was measured; empty if that is still to come.
    """

    evaluation: Evaluation | None = None
    cut: bool = False
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Grid:
    """A grid of a search.

    Attributes:
        stage: of the plan.
        shape: morphologies (rows) and rewards (columns).
        cells: every cell by row and column.
        reference_rewards: columns that are the task's own reward.
    """

    stage: Stage
    shape: tuple[int, int]
    cells: dict[tuple[int, int], Cell]
    reference_rewards: frozenset[int]


def grids(run: Run) -> tuple[Grid, ...]:
    """Return the grids of a run in which anything was measured, in the order of the search."""
    found = (_grid(run, stage) for stage in run.plan.stages if stage.is_grid)
    return tuple(grid for grid in found if any(cell.evaluation for cell in grid.cells.values()))


def _grid(run: Run, stage: Stage) -> Grid:
    cut = {id(record) for record in run.cut}
    cells = {
        place.index[:2]: Cell(reason=f"not tried: {reason}")
        for place, reason in run.untried.items()
        if place.stage == stage.name and len(place.index) > 1
    } | {
        record.place.index[:2]: Cell(record.evaluation, id(record) in cut)
        for record in run.records
        if record.place.stage == stage.name and len(record.place.index) > 1
    }
    rows, columns = (
        max([size, *(index[axis] + 1 for index in cells)])
        for axis, size in enumerate(stage.shape or (1, 1))
    )
    no_row = lines_without(run.empty, "morphology", stage)
    no_column = lines_without(run.empty, "reward", stage)
    if rows * columns > _MOST_CELLS:
        raise RunFolderError(
            f"{run.folder} has {rows} x {columns} pairs in the stage {stage.name!r}, more than "
            f"{_MOST_CELLS:,}; do not believe this run folder"
        )
    return Grid(
        stage=stage,
        shape=(rows, columns),
        cells={
            (i, j): cells.get((i, j)) or Cell(reason=no_row.get(i) or no_column.get(j, ""))
            for i in range(rows)
            for j in range(columns)
        },
        reference_rewards=frozenset(
            index[1]
            for index, cell in cells.items()
            if cell.evaluation and cell.evaluation.design.reward.source == run.task.reward
        ),
    )
