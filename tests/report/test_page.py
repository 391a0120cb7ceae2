"""The page stands alone, holds what a reader needs, and nothing a designer wrote runs in it."""

from __future__ import annotations

import base64
import hashlib
import html
import re
import warnings
import xml.etree.ElementTree as ElementTree
from contextlib import closing
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fake_run import (
    NASTY,
    PROVENANCE,
    SETTINGS,
    FakeRun,
    finished_run,
    foreign_run,
    random_run,
    reference_run,
)
from robomore.designers.recorded import ATTEMPTS
from robomore.errors import InputError
from robomore.events import Cut
from robomore.rendering.packing import unpack
from robomore.report import write_report
from robomore.report.heatmap import heatmap
from robomore.report.learning import learning_curves
from robomore.report.page import render
from robomore.report.plots import LEFT, best_so_far, fitness_over_volume
from robomore.report.replays import kept_policies, recorded
from robomore.report.scripts import bundle
from robomore.report.source import highlighted
from robomore.report.svg import Axis, axis_around
from robomore.runs import Run, load_run
from robomore.runs.grid import grids
from robomore.runs.words import with_interval
from robomore.settings import FinalSettings
from robomore.store import Ledger
from robomore.store.schema import Proposal
from robomore.types import Curve, Design, Place, Reward, Slot, Status

TIMES = "\N{MULTIPLICATION SIGN}"
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


METHODS = {
    "robomore": finished_run,
    "random": random_run,
    "reference": reference_run,
    "foreign": foreign_run,
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Run]:
    """A finished run of each method."""
    found = {}
    for name, write in METHODS.items():
        path = tmp_path_factory.mktemp(name)
        write(path)
        found[name] = load_run(path)
    return found


@pytest.fixture(scope="module")
def pages(runs: dict[str, Run]) -> dict[str, str]:
    return {name: write_report(run).read_text(encoding="utf-8") for name, run in runs.items()}


@pytest.fixture
def page(pages: dict[str, str]) -> str:
    return pages["robomore"]


def in_words(page: str) -> str:
    """Return the text of a page as a reader sees it, without its drawings."""
    text = re.sub(
        r"<script.*?</script>|<style.*?</style>|<svg.*?</svg>|<[^>]+>", " ", page, flags=re.DOTALL
    )
    return " ".join(text.split())


@pytest.mark.parametrize("method", METHODS)
def test_the_page_loads_nothing_and_runs_only_our_script(
    pages: dict[str, str], method: str
) -> None:
    page = pages[method]
    reader = Reader()
    reader.feed(page)
    assert reader.open == []
    # Places within the page, and nothing else.
    assert all(load.startswith("#") for load in reader.loads)
    scripts = re.findall(r"<script([^>]*)>(.*?)</script>", page, re.DOTALL)
    assert [text for kind, text in scripts if not kind] == [bundle()]
    assert all('type="application/octet-stream"' in kind for kind, _ in scripts if kind)
    still = page.replace(bundle(), "")
    assert "@import" not in still
    assert not re.search(r"url\(", still)
    assert "default-src &#39;none&#39;; script-src &#39;sha256-" in page


def test_the_script_that_the_policy_allows_is_the_one_in_the_page(page: str) -> None:
    (style,) = re.findall(r"<style>(.*?)</style>", page, re.DOTALL)
    for text in (style, bundle()):
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"sha256-{digest}" in html.unescape(page)


def packed(page: str, name: str) -> Any:
    """Return what a page carries for its scripts."""
    (text,) = re.findall(rf'data-pack="{name}">([^<]*)<', page)
    return unpack(base64.b64decode(text))


def test_every_evaluation_can_be_opened(pages: dict[str, str], runs: dict[str, Run]) -> None:
    for name, run in runs.items():
        data = packed(pages[name], "page")
        assert [one["key"] for one in data["evaluations"]] == [e.key for e in run.evaluations]
        for one, evaluation in zip(data["evaluations"], run.evaluations, strict=True):
            assert data["rewards"][one["r"]] == evaluation.design.reward.source
            assert data["morphologies"][one["m"]] == pytest.approx(
                evaluation.design.morphology.parameters
            )
            assert len(data["stills"][one["m"]]) == 3  # links of a swimmer
            assert one["status"] == evaluation.status
            # The marks that stand for it open it; what failed beside a grid is in the table alone.
            marked = f'data-key="{one["key"]}"' in pages[name]
            assert marked or not evaluation.ok or name == "reference"


def test_a_curve_comes_out_as_it_went_in(page: str, runs: dict[str, Run]) -> None:
    run = runs["robomore"]
    number, first = next((i, e) for i, e in enumerate(run.evaluations) if e.ok)
    given = run.curves()[first.key]
    found = packed(page, "curves")[number]
    assert tuple(found["steps"]) == given.steps
    series = found["series"]["episode_return"]
    assert series["at"][0] == 65535  # nothing was measured
    values = series["low"] + series["at"][1:] * series["step"]
    assert values == pytest.approx(given.series["episode_return"][1:], abs=1e-3)


def test_text_for_the_scripts_is_cleaned_too(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    reward = Reward(run.reward(1.0).source + "    # \u202eneddih\n", "\x1b[31mred")
    place = Place(stage="coarse", index=(0, 0), changed="re\u202eward", parent="\x1b[31mred")
    run.add(Design(run.morphology(0.5), reward), place, 3.0)
    data = packed(render(load_run(tmp_path)), "page")
    assert "\u202e" not in data["rewards"][0]
    one = data["evaluations"][0]
    assert "\x1b" not in one["ideas"][1] + one["parent"]
    assert "\u202e" not in one["changed"]


def test_what_a_designer_wrote_is_shown_as_text(page: str) -> None:
    assert "&lt;script&gt;alert" in page


def test_the_page_tells_result_provenance_and_warnings(page: str) -> None:
    text = in_words(page)
    assert f"7.50{TIMES} the reference design" in text
    interval = rf"Between [67]\.\d\d{TIMES} and [78]\.\d\d{TIMES} \(95 % interval over training"
    assert re.search(interval, text)
    assert PROVENANCE in page
    assert "The champion uses less material" in page
    assert "lighter" not in page
    assert "±" not in page
    assert "back_radius" in page
    assert "reward-failed" in page


def test_the_final_is_shown_as_two_by_two(page: str, runs: dict[str, Run]) -> None:
    text = in_words(page)
    pairs = runs["robomore"].pairs
    assert pairs is not None
    assert "The champion is the found morphology under the found reward" in text
    assert text.count(pairs.verdict) == 1
    for cell in (cell for row in pairs.cells for cell in row):
        assert cell.efficiency is not None
        assert text.count(with_interval(cell.efficiency, "m/m³")) >= 1
    assert re.search(r"found reward reference reward found morphology 1,474 m/m³", text)


def test_a_sentence_of_doubt_stands_once(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    run.final(run.coarse(), champion="reference")
    text = in_words(render(load_run(tmp_path)))
    assert text.count("Nothing that was found beats the reference design") == 1


def test_few_seeds_have_no_ratio_in_the_headline_and_show_their_values(tmp_path: Path) -> None:
    settings = replace(SETTINGS, final=FinalSettings(steps=4_000, episodes=4, seeds=2))
    run = FakeRun(tmp_path, settings=settings)
    two = (20.0, 21.0)
    run.final(run.coarse(), two, two, two, two)
    text = in_words(render(load_run(tmp_path)))
    assert f"{TIMES} the reference design" not in text
    assert "(seeds: " in text
    assert "95 % interval" not in text


def test_a_headline_without_an_interval_says_why(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    three = (20.0, 21.0, 22.0)
    run.final(run.coarse(), three, three, three, three)
    text = in_words(render(load_run(tmp_path)))
    assert f"{TIMES} the reference design" in text
    assert "No interval: 3 seeds, and it takes 5." in text


def test_behaviour_is_labelled_with_units_and_called_a_mean(page: str) -> None:
    text = in_words(page)
    assert "How it moves: means over 5 training seeds forward distance (m) 13.00" in text
    assert "forward speed (m/s) 1.300" in text
    assert "forward_speed" not in text


def test_the_methods_name_is_on_its_page_and_nothing_empty(pages: dict[str, str]) -> None:
    random, reference, foreign = (in_words(pages[n]) for n in ("random", "reference", "foreign"))
    assert "method random · seed 7" in random
    assert "The champion is the found morphology under the reference reward" in random
    assert "How the search found its best design" not in random
    assert "every morphology with every reward" not in random
    assert "What made the difference" not in reference
    assert "What the search measured" not in reference
    assert "method ours" in foreign
    assert "Stage matrix: every morphology with every reward" in foreign
    assert "evolution: generation 2, member 1" in foreign
    for text in (random, reference, foreign):
        assert "coarse" not in text
        assert "fine:" not in text


@pytest.mark.parametrize(
    ("method", "count"), [("robomore", 12), ("random", 11), ("reference", 5), ("foreign", 12)]
)
def test_its_figures_are_well_formed(pages: dict[str, str], method: str, count: int) -> None:
    page = pages[method].replace(bundle(), "")
    drawn = re.findall(r"<svg.*?</svg>", page, re.DOTALL)
    assert len(drawn) == count
    for svg in drawn:
        ElementTree.fromstring(svg)
        assert "nan" not in svg


@pytest.mark.parametrize("coarse", [False, True])
def test_a_run_that_goes_on_has_a_page_too(tmp_path: Path, coarse: bool) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    run.add(design, Place(stage="coarse", index=(0, 0)), None, Status.CRASHED, "gone")
    if coarse:
        run.coarse()
    text = render(load_run(tmp_path))
    assert ("so far" if coarse else "Nothing has been trained yet") in text


def test_a_page_that_cannot_be_written(tmp_path: Path) -> None:
    FakeRun(tmp_path).coarse()
    with pytest.raises(InputError, match="--out"):
        write_report(tmp_path, tmp_path / "nowhere" / "page.html")


def test_a_failed_cell_says_why_and_a_missing_one_that_it_is_missing(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    run.add(design, Place(stage="coarse", index=(0, 0)), None, Status.CRASHED, "it went away")
    (grid,) = grids(load_run(tmp_path))
    drawn = heatmap(grid, "efficiency", "m")
    assert "it went away" in drawn
    assert drawn.count('not measured yet"') == 11
    # The script says it to a finger and to the keyboard too, which cannot hover.
    assert drawn.count("aria-label=") == drawn.count('class="tip"') + 1 == 13
    assert drawn.count("data-key=") == 1


def test_cells_that_screening_cut_are_pale_and_say_so(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    run.add(design, Place(stage="coarse", index=(0, 1)), 3.0, steps=200)
    with closing(Ledger(run.folder.ledger)) as ledger:
        left_out = Place(stage="coarse", index=(1, 1))
        ledger.noting(lambda event: None)(Cut(left_out, 0, "number 4 of 4"))
    found = load_run(tmp_path)
    (grid,) = grids(found)
    drawn = heatmap(grid, "efficiency", "m")
    assert drawn.count('class="cut"') == 1
    assert "after 200 steps, cut by screening" in drawn
    assert "morphology 2 x reward 2: not tried: number 4 of 4" in drawn
    assert drawn.count('class="cell-untried"') == 1
    assert "Pale: cut by screening" in render(found)


def test_the_column_of_the_reference_reward_is_labelled(runs: dict[str, Run]) -> None:
    (grid,) = grids(runs["robomore"])
    drawn = heatmap(grid, "efficiency", "m")
    assert ">reference reward<" in drawn
    assert ">reward 1<" not in drawn
    assert ">reward 2<" in drawn
    (grid,) = grids(runs["foreign"])
    assert "reference" not in heatmap(grid, "efficiency", "m")


def test_designs_that_move_backwards_are_drawn_at_the_edge(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    for column, fitness in enumerate((-3.0, 0.0, 5.0)):
        design = Design(run.morphology(0.5), run.reward(1.0 + column))
        run.add(design, Place(stage="coarse", index=(0, column)), fitness)
    found = load_run(tmp_path)
    (grid,) = grids(found)
    for drawn in (heatmap(grid, "efficiency", "m"), best_so_far(found), fitness_over_volume(found)):
        ElementTree.fromstring(drawn)
        assert "nan" not in drawn
    assert "A dot at the lower edge: 0 or less" in render(found)


def test_a_label_does_not_stand_on_the_numbers_of_the_axis(tmp_path: Path) -> None:
    run = FakeRun(tmp_path, "half-cheetah")
    for column, (radius, fitness) in enumerate(((0.2, 10.0), (1.0, 0.5), (1.0, 10.0))):
        design = Design(run.morphology(radius), run.reward(1.0 + column))
        run.add(design, Place(stage="coarse", index=(0, column)), fitness)
    found = load_run(tmp_path)
    assert "lower edge" not in render(found)
    drawn = fitness_over_volume(found)
    ended = re.findall(r'([0-9.]+),[0-9.]+" class="equal"></polyline><text([^>]*)>', drawn)
    beside = [float(x) - LEFT < 60 for x, _ in ended]
    assert beside == ['text-anchor="start"' in attributes for _, attributes in ended]
    assert any(beside) and not all(beside)


def heights(drawn: str) -> list[list[float]]:
    """Return the heights of the points of each line of a learning curve, upwards."""
    paths = re.findall(r'<path d="M([^"]+)" class="curve', drawn)
    return [[-float(point.split()[1]) for point in path.split("L")] for path in paths]


def test_learning_curves_show_every_seed_and_the_champions_terms(runs: dict[str, Run]) -> None:
    champion, reference, terms = learning_curves(runs["robomore"])
    assert champion.title == "Champion: return of its own reward"
    for panel in (champion, reference):
        lines = heights(panel.drawn)
        assert len(lines) == 5
        # Nothing is drawn where no episode had ended.
        assert all(len(line) == 4 and line == sorted(line) for line in lines)
    rising, falling = heights(terms.drawn)
    assert rising == sorted(rising)
    assert falling == sorted(falling, reverse=True)
    assert [name for _, name in terms.legend] == ["forward", "<b>effort"]


def test_a_curve_of_one_point_is_a_dot(
    runs: dict[str, Run], monkeypatch: pytest.MonkeyPatch
) -> None:
    curve = Curve((100, 200), {"episode_return": (None, 1.5)})
    curves = {one.key: curve for one in runs["robomore"].evaluations}
    monkeypatch.setattr(Run, "curves", lambda self: curves)
    champion = learning_curves(runs["robomore"])[0]
    assert champion.drawn.count("<circle") == 5


def test_names_of_terms_are_shown_as_text(page: str) -> None:
    assert "&lt;b&gt;effort" in page
    assert "<b>effort" not in page


def test_without_curves_there_is_no_empty_section(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    best = run.add(design, Place(stage="coarse", index=(0, 1)), 3.0)
    with closing(Ledger(run.folder.ledger)) as ledger:
        ledger._execute("DELETE FROM curves")
    found = load_run(tmp_path)
    assert found.curve(best.key) is None
    assert learning_curves(found) == []
    assert "Learning curves" not in in_words(render(found))


def test_slots_that_stayed_empty_are_on_the_page(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    with closing(Ledger(run.folder.ledger)) as ledger:
        for attempt in range(ATTEMPTS):
            slot = Slot("coarse", "morphology", (1,), attempt=attempt)
            ledger.add_proposal(Proposal(slot, failure=NASTY), "")
    page = render(load_run(tmp_path))
    assert "Slots that stayed empty" in page
    assert "coarse morphology 2" in page
    assert NASTY not in page


def test_an_edited_task_is_named_on_the_page(tmp_path: Path) -> None:
    run = finished_run(tmp_path)
    replace(run.manifest, task_parts={"template": "other"}).save(run.folder.manifest)
    assert "The task swimmer was edited after this run" in render(load_run(tmp_path))


def test_an_axis_stands_where_it_should() -> None:
    axis = Axis(1.0, 100.0, 0.0, 200.0, log=True)
    assert axis.at(10.0) == pytest.approx(100.0)
    assert axis.at(0.0) == pytest.approx(0.0)
    assert axis.ticks() == pytest.approx([1, 2, 5, 10, 20, 50, 100][::2])
    assert Axis(0.0, 1.0, 0.0, 1.0).ticks() == pytest.approx([0, 0.2, 0.4, 0.6, 0.8, 1.0])
    flat = axis_around([5.0, 5.0], 0.0, 1.0)
    assert flat.low < 5.0 < flat.high
    for extreme in ([1e308, -1e308], [1e308, 1e308], [1e200, 1e300], [-1e308, 0.0]):
        wide = axis_around(extreme, 0.0, 1.0)
        assert wide.ticks() and all(0.0 <= wide.at(value) <= 1.0 for value in extreme)


def test_text_that_is_no_python_stays_as_it_is() -> None:
    assert highlighted("if <b>:\n '''") == "if &lt;b&gt;:\n &#x27;&#x27;&#x27;"
    assert highlighted("return 1") == (
        '<span class="keyword">return</span> <span class="literal">1</span>'
    )


def test_a_policy_whose_numbers_overflow_is_shown_without_a_word_of_numpy(
    trained_run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = load_run(trained_run)
    key = next(iter(kept_policies(run)))
    policy = run.load_policy(key)
    large = tuple(np.full_like(weight, 3e38) for weight in policy.weights)
    monkeypatch.setattr(Run, "load_policy", lambda *_: replace(policy, weights=large))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert recorded(run, key, "overflowing") is not None
