"""The page tells what a search compared, whatever it was."""

from __future__ import annotations

import re

import pytest

from fake_run import economy_run
from robomore.report.heatmap import heatmap
from robomore.report.page import render
from robomore.runs import Run, load_run
from robomore.runs.grid import grids
from robomore.runs.scores import scored
from robomore.runs.words import in_unit, number


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    path = tmp_path_factory.mktemp("economy")
    economy_run(path)
    return load_run(path)


def test_the_page_tells_the_way_in_the_objective(run: Run) -> None:
    page = " ".join(re.sub("<[^>]+>", "", render(run)).split())
    way = page[page.index("How the search found its best design") :]
    for record in run.lineage:
        assert scored(record.evaluation, run.objective, "m") in way
    first = run.lineage[0].evaluation
    assert scored(first, "efficiency", "m").startswith(in_unit(first.efficiency, "efficiency", "m"))
    score = run.champion.score(run.objective) if run.champion else None
    assert score is not None
    assert f"transport economy (1 / cost of transport){number(score.mean)}" in page
    assert "of each pair, log colour" in page


def test_a_cell_says_what_its_colour_is_of(run: Run) -> None:
    (grid,) = grids(run)
    drawn = heatmap(grid, run.objective, "m")
    cell = grid.cells[0, 0].evaluation
    assert cell is not None
    assert f"{in_unit(cell.score(run.objective), run.objective, 'm')}; " in drawn
