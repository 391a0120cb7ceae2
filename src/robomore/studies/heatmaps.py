"""The grids of the coarse stage as heat maps, random, without and with Diversity Reflection."""

from __future__ import annotations

from functools import partial

from robomore.runs.grid import grids
from robomore.studies.diversity import RANDOM
from robomore.studies.scores import found_table
from robomore.studies.study import PROPOSED, Arm, Draw, Results, Study
from robomore.studies.table import Table
from robomore.visualize.search import heatmap


def _tables(results: Results) -> list[Table]:
    return [found_table(results)]


def _figures(results: Results) -> dict[str, Draw]:
    return {cell.folder.name: partial(heatmap, run) for cell, run in results.cells if grids(run)}


HEATMAPS = Study(
    name="heatmaps",
    summary="the grid of morphologies and rewards, log scale: random, with and without diversity",
    arms=(
        RANDOM,
        Arm("without-diversity", {"method_options": {"without": ["diversity", "fine"]}}),
        Arm("with-diversity", {"method_options": {"without": ["fine"]}}),
    ),
    tables=_tables,
    figures=_figures,
    change=PROPOSED,
    whole_grid=True,
)
