"""A design that one run found, trained anew where another cell says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from robomore.errors import InputError, NothingTrained
from robomore.options import with_options
from robomore.runs import Run
from robomore.studies.study import Cell

GIVEN = "given"
"""The method that trains one design and searches nothing."""


def retraining(cell: Cell, done: Sequence[tuple[Cell, Run]]) -> Cell:
    """Return a cell with the design that its `retrains` found.

    Args:
        cell: one that trains what another one found.
        done: the cells so far, with their runs.

    Raises:
        InputError: the search is not among the cells.
        NothingTrained: it found nothing.
    """
    source = cell.retrains
    assert source is not None
    runs = [run for one, run in done if one.folder == source.folder]
    if not runs:
        raise InputError(
            f"{cell.folder.name} trains what {source.folder.name} finds; leave its arm in the study"
        )
    found = runs[0].found
    if found is None:
        raise NothingTrained(
            f"{source.folder.name} found no design that could be trained in {cell.task}"
        )
    design = {
        "parameters": list(found.design.morphology.parameters),
        "reward": found.design.reward.source,
    }
    return replace(cell, settings=with_options(cell.settings, method=GIVEN, method_options=design))
