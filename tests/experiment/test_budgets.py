"""Another budget in the same folder: the search goes on, and no earlier final is left over."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

import untrained  # noqa: F401  # makes its executor known
from robomore.errors import InputError, Interrupted
from robomore.events import Event, Finished, Observer, ignore
from robomore.experiment import run
from robomore.options import with_options
from robomore.runs import Run, load_run
from robomore.settings import preset
from robomore.store import Ledger, RunFolder
from robomore.types import Evaluation, Place

SETTINGS = with_options(preset("smoke"), method="random", evaluations=8, finalists=2, final_seeds=2)
STEPS = SETTINGS.candidate.steps


def start(out: Path, trainings: int | None, observe: Observer = ignore) -> Run:
    budget = None if trainings is None else trainings * STEPS
    return run(
        "swimmer",
        SETTINGS,
        executor="untrained",
        out=out,
        seed=1,
        budget_steps=budget,
        observe=observe,
    )


def finals(found: Run) -> list[tuple[Place, str]]:
    return [(r.place, r.evaluation.key) for r in found.records if r.place.stage == "final"]


def test_a_larger_budget_leaves_one_final_as_if_it_had_been_the_first(tmp_path: Path) -> None:
    first = start(tmp_path / "grown", 2)
    grown = start(tmp_path / "grown", 8)
    assert first.found != grown.found, "choose another seed: nothing better was found"
    whole = start(tmp_path / "whole", 8)
    assert finals(grown) == finals(whole)
    assert len(finals(grown)) == 5 * 2, "two finalists, the reference and two pairs, twice each"
    assert grown.champion == whole.champion and grown.search_steps == 8 * STEPS
    assert grown.cost.steps == whole.cost.steps
    assert grown.cost.evaluations == whole.cost.evaluations
    assert {e.key for e in grown.measured} == {e.key for e in whole.measured}
    with closing(Ledger(RunFolder(tmp_path / "grown").ledger, read_only=True)) as ledger:
        assert len(ledger.evaluations()) > len(grown.measured), "what was trained is kept"


def test_a_run_that_goes_on_with_a_larger_budget_is_not_finished(tmp_path: Path) -> None:
    assert start(tmp_path, 2).final

    def stop(event: Event) -> None:
        if isinstance(event, Finished) and not event.known:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted):
        start(tmp_path, 8, observe=stop)
    between = load_run(tmp_path)
    assert not between.final and between.champion is not None
    assert start(tmp_path, 8).final


def test_a_budget_below_what_was_spent_is_refused_and_changes_nothing(tmp_path: Path) -> None:
    before = start(tmp_path, 8)
    with pytest.raises(
        InputError, match=rf"trained for {8 * STEPS} steps.*--budget-steps {8 * STEPS}"
    ):
        start(tmp_path, 2)
    after = load_run(tmp_path)
    assert after.champion == before.champion and finals(after) == finals(before)
    assert start(tmp_path, 8).champion == before.champion
    assert start(tmp_path, None).champion == before.champion
    assert start(tmp_path, 9).champion == before.champion, "more than the search needs"


def test_a_budget_after_a_search_without_one_is_held_to_what_that_spent(tmp_path: Path) -> None:
    start(tmp_path, None)
    with pytest.raises(InputError, match="takes nothing back"):
        start(tmp_path, 7)
    start(tmp_path, 8)


def test_what_was_spent_under_the_same_budget_is_no_reason_to_refuse(tmp_path: Path) -> None:
    """A fault of the machine, gone when the run goes on, can lead the search elsewhere."""
    before = start(tmp_path, 4)
    with closing(Ledger(RunFolder(tmp_path).ledger)) as ledger:
        _place(ledger, before.searched[0].evaluation)
    assert start(tmp_path, 4).champion == before.champion


def _place(ledger: Ledger, known: Evaluation) -> None:
    """Add a training that the search no longer asks for."""
    other = replace(known, key="elsewhere", job=replace(known.job, seed=known.job.seed + 1))
    ledger.add_place(Place(stage="samples", index=(7,)), other.key)
    ledger.add_evaluation(other)
