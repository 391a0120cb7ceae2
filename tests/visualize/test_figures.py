"""Figures return Matplotlib axes that hold a run's own numbers."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import matplotlib
import numpy as np
import pytest

from fake_run import FOUND_FITNESS, FakeRun, finished_run, foreign_run, random_run, reference_run
from robomore.errors import InputError
from robomore.runs import Run, compare, load_run
from robomore.runs.progress import progress
from robomore.types import Design, Place, Status
from robomore.visualize import (
    best_so_far,
    fitness_over_volume,
    heatmap,
    learning_curve,
    pairs,
    parameters,
)
from robomore.visualize.studies import episodes

matplotlib.use("agg")

from matplotlib import pyplot as plt


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    path = tmp_path_factory.mktemp("finished")
    finished_run(path)
    return load_run(path)


@pytest.fixture(autouse=True)
def close_figures() -> Iterator[None]:
    yield
    plt.close("all")


def test_a_figure_can_be_drawn_on_axes_that_are_given(run: Run) -> None:
    _, ax = plt.subplots()
    open_now = plt.get_fignums()
    for draw in (heatmap, best_so_far, fitness_over_volume, pairs, parameters):
        ax.clear()
        assert draw(run, ax) is ax
    assert learning_curve(run, ax=ax) is ax
    assert plt.get_fignums() == open_now


def test_a_heat_map_holds_the_grid(run: Run) -> None:
    ax = heatmap(run)
    shown = np.ma.filled(ax.images[0].get_array(), np.nan)
    expected = [
        [run.evaluation(f"key{1 + 3 * i + j:03d}").efficiency for j in range(3)] for i in range(4)
    ]
    np.testing.assert_allclose(shown, np.array(expected, dtype=float))
    assert np.isnan(shown).sum() == 1
    assert [text.get_text() for text in ax.get_xticklabels()] == ["reference", "2", "3"]
    assert [t.get_text() for t in ax.texts].count("x") == 1
    assert ax.get_title() == "coarse"


def test_a_grid_is_found_whatever_its_stage_is_called(tmp_path: Path) -> None:
    foreign_run(tmp_path)
    assert heatmap(load_run(tmp_path)).get_title() == "matrix"
    with pytest.raises(InputError, match="no stage called 'evolution'"):
        heatmap(load_run(tmp_path), stage="evolution")


def test_a_method_without_a_grid_is_told_what_to_draw_instead(tmp_path: Path) -> None:
    random_run(tmp_path)
    with pytest.raises(InputError, match="best_so_far"):
        heatmap(load_run(tmp_path))


def test_the_best_so_far_over_control_steps(run: Run) -> None:
    ax = best_so_far(run)
    dots, best, level = ax.lines
    points = progress(run)
    np.testing.assert_allclose(dots.get_xdata(), [point.steps for point in points])
    np.testing.assert_allclose(dots.get_ydata(), [point.score for point in points])
    np.testing.assert_allclose(best.get_ydata(), np.maximum.accumulate(dots.get_ydata()))
    assert run.reference is not None
    assert run.reference.efficiency is not None
    assert level.get_ydata()[0] == pytest.approx(run.reference.efficiency.mean)
    assert ax.get_xlabel() == "control steps of training in the search"
    assert ax.get_ylabel() == "efficiency (m/m³)"


def test_several_runs_are_lines_of_one_figure(run: Run, tmp_path: Path) -> None:
    random_run(tmp_path)
    ax = best_so_far(compare([run, tmp_path]))
    assert [line.get_label() for line in ax.lines] == ["robomore, seed 7", "random, seed 7"]
    assert [line.get_xdata()[-1] for line in ax.lines] == [15_000, 4_000]


def test_lines_of_one_method_are_told_apart_and_share_an_axis(run: Run) -> None:
    budget = replace(run, budget_steps=9_000)
    said = [str(line.get_label()) for line in best_so_far(compare([run, budget])).lines]
    assert said[1] == said[0] + ", with budget steps 9,000"
    settings = replace(run.manifest.settings, objective="fitness")
    other = replace(run, manifest=replace(run.manifest, settings=settings))
    with pytest.raises(
        InputError, match=r"different things \(efficiency \(m/m³\), fitness \(m\)\)"
    ):
        best_so_far(compare([run, other]))


def test_the_pairs_are_bars_with_a_dot_for_each_seed(run: Run) -> None:
    ax = pairs(run)
    assert run.pairs is not None
    cells = [cell for row in run.pairs.cells for cell in row]
    for bar, dots, line, cell in zip(ax.patches, ax.collections, ax.lines, cells, strict=True):
        assert cell.efficiency is not None
        assert bar.get_height() == pytest.approx(cell.efficiency.mean)
        np.testing.assert_allclose(dots.get_offsets()[:, 1], cell.efficiency.values)
        assert cell.efficiency.interval is not None
        np.testing.assert_allclose(line.get_ydata(), cell.efficiency.interval)
    assert [text.get_text() for text in ax.get_xticklabels()] == [
        "found morphology\nfound reward",
        "found morphology\nreference reward",
        "reference morphology\nfound reward",
        "reference morphology\nreference reward",
    ]


def test_one_pair_alone_is_no_figure(tmp_path: Path) -> None:
    reference_run(tmp_path)
    with pytest.raises(InputError, match="no pairs to compare"):
        pairs(load_run(tmp_path))


def test_learning_curves_of_the_champion_or_of_one_evaluation(run: Run) -> None:
    lines = learning_curve(run).lines
    assert [line.get_ydata()[-1] for line in lines] == list(FOUND_FITNESS)
    assert all(np.isnan(line.get_ydata()[0]) for line in lines)
    (one,) = learning_curve(run, "key001", series="term/forward").lines
    assert list(one.get_xdata()) == [200, 400, 600, 800, 1_000]
    np.testing.assert_allclose(one.get_ydata(), [2.0, 4.0, 6.0, 8.0, 10.0])
    with pytest.raises(InputError, match=r"no curve of 'speed'.*episode_return"):
        learning_curve(run, series="speed")


def test_all_designs_by_volume_and_fitness(run: Run) -> None:
    ax = fitness_over_volume(run)
    shown = {dots.get_label(): dots.get_offsets() for dots in ax.collections}
    assert {name: len(points) for name, points in shown.items()} == {
        "coarse": 11,
        "fine": 3,
        "final": 20,
    }
    first = run.evaluation("key001")
    np.testing.assert_allclose(shown["coarse"][0], [first.volume, first.fitness])
    assert ax.get_xscale() == "log"


def test_parameters_stand_between_their_bounds(run: Run) -> None:
    ax = parameters(run)
    reference, champion = ax.lines
    assert [text.get_text() for text in ax.get_yticklabels()] == list(run.task.names)
    at = run.task.names.index("front_radius")
    parameter = run.task.parameters[at]
    low, high = np.log(parameter.low), np.log(parameter.high)
    assert parameter.scale == "log"
    assert reference.get_xdata()[at] == pytest.approx((np.log(0.1) - low) / (high - low))
    assert champion.get_xdata()[at] == pytest.approx((np.log(0.03) - low) / (high - low))


def test_nothing_trained_is_no_figure(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    run.add(design, Place(stage="coarse", index=(0, 0)), None, Status.CRASHED, "gone")
    found = load_run(tmp_path)
    for draw in (best_so_far, fitness_over_volume, parameters):
        with pytest.raises(InputError, match="nothing has been trained yet"):
            draw(found)


def test_without_matplotlib_the_remedy_is_named(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    load = importlib.import_module

    def without(name: str) -> ModuleType:
        if name.startswith("matplotlib"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return load(name)

    monkeypatch.setattr(importlib, "import_module", without)
    for draw in (heatmap, best_so_far, fitness_over_volume, pairs, parameters, learning_curve):
        with pytest.raises(InputError, match=r'pip install "robomore\[plot\]"'):
            draw(run)


def test_episodes_carry_the_unit_they_are_given() -> None:
    axes = episodes({"rolling": (1.0, 2.0)}, "fitness (J)")
    assert axes.get_ylabel() == "fitness (J)"
    plt.close(axes.figure)
