"""As many designs go into the final as were asked for, whatever the method returns."""

from __future__ import annotations

from pathlib import Path

import untrained  # noqa: F401  # makes its executor known
from robomore.experiment import run
from robomore.options import with_options
from robomore.runs import Run
from robomore.search.measure import content
from robomore.settings import preset


def finalists(found: Run) -> list[object]:
    """Return the designs that the final trained as such, in their order."""
    first = {
        r.place.index: content(r.evaluation.design)
        for r in found.records
        if r.place.stage == "final" and r.place.changed == "found"
    }
    return [first[index] for index in sorted(first)]


def test_a_search_with_one_branch_fills_three_seats_with_its_best_designs(tmp_path: Path) -> None:
    settings = with_options(preset("smoke"), finalists=3)
    found = run("swimmer", settings, executor="untrained", out=tmp_path, seed=2)
    assert {r.place.index[0] for r in found.records if r.place.stage == "fine"} == {0}
    scored = sorted(found.searched, key=lambda r: -(r.evaluation.efficiency or 0.0))
    best = list(dict.fromkeys(content(r.evaluation.design) for r in scored))
    assert finalists(found) == best[:3] and len(best) > 3


def test_the_best_of_each_branch_go_before_all_others(tmp_path: Path) -> None:
    options = {"survivors": 0.5, "max_cycles": 2}
    settings = with_options(preset("smoke"), method_options=options, finalists=4)
    found = run("swimmer", settings, executor="untrained", out=tmp_path, seed=2)
    grid = [r.evaluation for r in found.searched if r.place.stage == "coarse"]
    starts = sorted(grid, key=lambda one: -(one.efficiency or 0.0))[:2]
    best = dict(enumerate(starts))
    for record in (r for r in found.searched if r.place.stage == "fine"):
        branch, new = record.place.index[0], record.evaluation
        if (new.efficiency or 0) > (best[branch].efficiency or 0):
            best[branch] = new
    leading = sorted(best.values(), key=lambda one: -(one.efficiency or 0.0))
    assert finalists(found)[:2] == [content(one.design) for one in leading]
    assert len(finalists(found)) == 4
