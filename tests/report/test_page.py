"""The page stands alone, holds what a reader needs, and nothing a designer wrote runs in it."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from html.parser import HTMLParser
from pathlib import Path

import pytest

from fake_run import PROVENANCE, FakeRun, finished_run
from robomore.errors import InputError
from robomore.report import summarise, write_report
from robomore.report.heatmap import heatmap
from robomore.report.page import render
from robomore.report.plots import best_so_far, fitness_over_volume
from robomore.report.source import highlighted
from robomore.report.svg import Axis, axis_around
from robomore.types import Design, Place, Status

_VOID = {"meta", "br", "link", "img", "hr", "input"}


class Reader(HTMLParser):
    """Collects what a browser would load or run, and whether every element is closed."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.loads: list[str] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        if tag not in _VOID:
            self.open.append(tag)
        for name, value in attributes:
            if name in {"src", "href", "xlink:href", "action", "data", "srcset"}:
                self.loads.append(value or "")

    def handle_endtag(self, tag: str) -> None:
        if tag in {"p", "li", "dt", "dd"}:
            while self.open[-1] != tag:
                self.open.pop()
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("page")
    finished_run(path)
    return write_report(path).read_text(encoding="utf-8")


def test_the_page_loads_nothing_and_runs_nothing(page: str) -> None:
    reader = Reader()
    reader.feed(page)
    assert reader.open == []
    assert reader.loads == []
    assert "script" not in reader.tags
    assert "<script" not in page
    assert "@import" not in page
    assert not re.search(r"url\(", page)
    assert "default-src 'none'" in page


def test_what_a_designer_wrote_is_shown_as_text(page: str) -> None:
    assert "&lt;script&gt;alert" in page


def test_the_page_tells_result_provenance_and_cautions(page: str) -> None:
    assert "<b>7.50" in page
    assert PROVENANCE in page
    assert "The champion is the lighter robot" in page
    assert "back_radius" in page
    assert "reward-failed" in page


def test_its_figures_are_well_formed(page: str) -> None:
    drawn = re.findall(r"<svg.*?</svg>", page, re.DOTALL)
    assert len(drawn) == 7
    for svg in drawn:
        ElementTree.fromstring(svg)


@pytest.mark.parametrize("coarse", [False, True])
def test_a_run_that_goes_on_has_a_page_too(tmp_path: Path, coarse: bool) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    run.add(design, Place(stage="coarse"), None, Status.CRASHED, "gone")
    if coarse:
        run.coarse()
    text = render(summarise(tmp_path))
    assert ("so far" if coarse else "Nothing has been trained yet") in text


def test_a_page_that_cannot_be_written(tmp_path: Path) -> None:
    FakeRun(tmp_path).coarse()
    with pytest.raises(InputError, match="--out"):
        write_report(tmp_path, tmp_path / "nowhere" / "page.html")


def test_a_failed_cell_says_why_and_a_missing_one_that_it_is_missing(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    run.add(design, Place(stage="coarse"), None, Status.CRASHED, "it went away")
    drawn = heatmap(summarise(tmp_path))
    assert "it went away" in drawn
    assert drawn.count("not measured yet") == 11


def test_designs_that_move_backwards_are_drawn_at_the_edge(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    for column, fitness in enumerate((-3.0, 0.0, 5.0)):
        design = Design(run.morphology(0.5), run.reward(1.0 + column))
        run.add(design, Place(stage="coarse", reward=column), fitness)
    summary = summarise(tmp_path)
    for drawn in (heatmap(summary), best_so_far(summary), fitness_over_volume(summary)):
        ElementTree.fromstring(drawn)
        assert "nan" not in drawn


def test_an_axis_stands_where_it_should() -> None:
    axis = Axis(1.0, 100.0, 0.0, 200.0, log=True)
    assert axis.at(10.0) == pytest.approx(100.0)
    assert axis.at(0.0) == pytest.approx(0.0)
    assert axis.ticks() == pytest.approx([1, 2, 5, 10, 20, 50, 100][::2])
    assert Axis(0.0, 1.0, 0.0, 1.0).ticks() == pytest.approx([0, 0.2, 0.4, 0.6, 0.8, 1.0])
    flat = axis_around([5.0, 5.0], 0.0, 1.0)
    assert flat.low < 5.0 < flat.high


def test_text_that_is_no_python_stays_as_it_is() -> None:
    assert highlighted("if <b>:\n '''") == "if &lt;b&gt;:\n &#x27;&#x27;&#x27;"
    assert highlighted("return 1") == (
        '<span class="keyword">return</span> <span class="literal">1</span>'
    )
