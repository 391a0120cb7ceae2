"""The slimmed reference design as something to compare with, where a search has tried it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from fake_run import FakeRun
from robomore.runs import load_run
from robomore.runs.slimmed import over_slimmed, slim_scale
from robomore.tasks import get_task
from robomore.types import Design, Morphology, Place

STEADY = (20.0, 20.1, 20.2, 20.3, 20.4)


def searched(path: Path, slim: float | None, final: bool = True, preset: str = "quick") -> None:
    """Write a run that found a longer robot, and tried the slimmed reference if `slim` is given."""
    run = FakeRun(path, preset=preset)
    first, *others = run.morphology(0.5).parameters
    longer = Design(Morphology((1.1 * first, *others)), run.reward(3.0))
    best = run.add(longer, Place(stage="coarse", index=(1, 1)), 30.0)
    for column, fitness in enumerate((0.5, slim) if slim is not None else ()):
        design = Design(run.morphology(0.5), run.reward(column))
        run.add(design, Place(stage="coarse", index=(0, column)), fitness)
    if final:
        pairs = dict.fromkeys(("found", "reference", "morphology_only", "reward_only"), STEADY)
        run.final(best, **pairs)


def test_the_searchs_best_is_told_over_the_best_slimmed_reference(tmp_path: Path) -> None:
    searched(tmp_path, 10.0)
    run = load_run(tmp_path)
    worth = {one.place.index: one.evaluation.efficiency or 0.0 for one in run.searched}
    ratio = f"{worth[1, 1] / worth[0, 1]:.2f}"
    said = over_slimmed(run)
    assert said.startswith(f"The search's best has {ratio} times the efficiency of the slimmed")
    assert "each trained once with 1,000 control steps" in said
    assert said in run.report().read_text().replace("&#39;", "'")


@pytest.mark.parametrize(
    ("slim", "final", "preset"),
    [(None, True, "quick"), (60.0, True, "quick"), (10.0, False, "quick"), (10.0, True, "smoke")],
)
def test_nothing_is_told_where_there_is_nothing_to_tell(
    slim: float | None, final: bool, preset: str, tmp_path: Path
) -> None:
    """Not tried, the best itself, not finished, and trained for nothing."""
    searched(tmp_path, slim, final, preset)
    assert over_slimmed(load_run(tmp_path)) == ""


def test_one_evaluation_is_not_the_search(tmp_path: Path) -> None:
    searched(tmp_path, 10.0)
    run = load_run(tmp_path)
    assert over_slimmed(run) and not over_slimmed(run.focused(run.evaluations[0].key))
    assert not over_slimmed(replace(run, records=()))


def test_a_scale_is_that_of_all_radii_and_of_nothing_else() -> None:
    task = get_task("swimmer")
    radius = of_radii(task.names)
    half = [p / 2 if thin else p for p, thin in zip(task.reference, radius, strict=True)]
    assert slim_scale(task, half) == pytest.approx(0.5)
    assert slim_scale(task, task.reference) is None
    longer = [p if thin else 1.1 * p for p, thin in zip(half, radius, strict=True)]
    assert slim_scale(task, longer) is None
    uneven = [*half[:-1], 1.5 * half[-1]]
    assert slim_scale(task, uneven) is None


def of_radii(names: tuple[str, ...]) -> list[bool]:
    return ["radius" in name for name in names]
