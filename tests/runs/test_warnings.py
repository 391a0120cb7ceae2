"""Reasons to doubt a champion are found from the numbers, and only where they hold."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from fake_run import SETTINGS, FakeRun, finished_run
from robomore.runs import load_run
from robomore.store import Ledger
from robomore.types import Design, Morphology, Place, Status

STEADY = (20.0, 20.1, 20.2, 20.3, 20.4)


def said(path: Path) -> str:
    return " ".join(load_run(path).warnings)


def test_a_champion_that_only_shrank_uses_less_material(tmp_path: Path) -> None:
    finished_run(tmp_path)
    found = said(tmp_path)
    assert "uses less material, but it does not do better" in found
    assert "13.00 against 21.00 m" in found
    assert "lighter" not in found


@pytest.mark.parametrize(("height", "told"), [(5.0, True), (9.0, False)])
def test_a_champion_that_mostly_stands_tall_is_told_so(
    height: float, told: bool, tmp_path: Path
) -> None:
    run = FakeRun(tmp_path, "ant-jump")  # its torso starts at 4 m
    design = Design(run.morphology(0.5), run.reward(3.0))
    best = run.add(design, Place(stage="coarse", index=(0, 1)), height)
    run.final(best, found=(height,) * 5)
    found = said(tmp_path)
    assert ("Of the 5.000 m that the champion reaches, 4.000 m is the height" in found) is told
    assert ("it gains 1.000 m" in found) is told
    assert "Of the 9" not in found


def test_a_sound_result_has_no_warning(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    first, *others = run.morphology(0.5).parameters
    longer = Morphology((1.1 * first, *others))
    best = run.add(Design(longer, run.reward(3.0)), Place(stage="coarse", index=(0, 1)), 31.0)
    high = tuple(value + 10 for value in STEADY)
    run.final(best, found=high, reference=STEADY, morphology_only=STEADY, reward_only=STEADY)
    assert load_run(tmp_path).warnings == ()


@pytest.mark.parametrize(
    ("champion", "words"),
    [("found", "and could not be champion"), ("reference", "it is champion all the same")],
)
def test_a_reference_beyond_the_limits_is_told_with_the_seat_that_it_has(
    champion: str, words: str, tmp_path: Path
) -> None:
    run = FakeRun(tmp_path, settings=replace(SETTINGS, max_volume=0.05))
    run.final(run.fine(run.coarse()), champion=champion)
    assert words in said(tmp_path)


def test_an_unfinished_run_says_so_first(tmp_path: Path) -> None:
    FakeRun(tmp_path).coarse()
    assert load_run(tmp_path).warnings[0].startswith("The run is not finished")


def test_nothing_trained_is_all_there_is_to_say(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    design = Design(run.morphology(0.5), run.reward(1.0))
    run.add(design, Place(stage="coarse", index=(0, 0)), None, Status.CRASHED, "gone")
    assert load_run(tmp_path).warnings == ("Nothing has been trained successfully yet.",)


def test_few_seeds_and_luck_are_named(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    run.final(run.fine(run.coarse()), (2.0, 3.0), (1.0, 1.0), (1.0, 1.0), (1.0, 1.0))
    found = said(tmp_path)
    assert "Only 2 training seeds in the final" in found
    assert "partly luck" in found


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        (1_000, "both after 1,000 control steps: the best of many noisy numbers is partly luck."),
        (4_000, "is partly luck, and part of that luck is hidden by the longer training."),
        (500, "is partly luck, and the shorter training may be the other part."),
    ],
)
def test_luck_is_told_with_both_numbers_of_steps(tmp_path: Path, steps: int, words: str) -> None:
    final = replace(SETTINGS.final, steps=steps)
    run = FakeRun(tmp_path, settings=replace(SETTINGS, final=final))
    run.final(run.fine(run.coarse()), found=(2.0,) * 5)
    found = said(tmp_path)
    assert words in found
    if steps != 1_000:
        assert "after 1,000 control steps, training anew" in found
        assert f"after {steps:,}: " in found


def test_an_improvement_is_no_luck(tmp_path: Path) -> None:
    run = FakeRun(tmp_path, settings=replace(SETTINGS, objective="fitness"))
    design = Design(run.morphology(0.5), run.reward(1.0))
    best = run.add(design, Place(stage="coarse", index=(0, 1)), -100.0)
    run.final(best, found=(-80.0,) * 5)
    assert "partly luck" not in said(tmp_path)


def test_a_reference_that_gets_nowhere_is_named(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    run.final(run.coarse(), reference=(-1.0, 0.0, -0.5, -0.2, 0.1))
    assert "did not get anywhere at this budget" in said(tmp_path)


def test_a_training_of_the_reference_that_gets_nowhere_is_named(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    run.final(run.coarse(), reference=(-0.5, 0.1, 0.6, -0.1, 0.05))
    found = said(tmp_path)
    assert "2 of 5 trainings of the reference design did not get anywhere" in found
    assert "did not get anywhere at this budget" not in found


def test_the_smoke_preset_is_named(tmp_path: Path) -> None:
    FakeRun(tmp_path, preset="smoke-random").coarse()
    assert "smoke preset only checks" in said(tmp_path)


def test_failed_trainings_of_the_final_are_counted(tmp_path: Path) -> None:
    run = FakeRun(tmp_path, settings=replace(SETTINGS, objective="fitness"))
    run.final(run.coarse())
    one = load_run(tmp_path).champion
    assert one is not None
    run.fail(one.evaluations[0])
    assert "1 of 5 final trainings of the champion design failed (unstable)" in said(tmp_path)


def test_matter_denser_than_steel_is_named(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    best = run.coarse()
    with closing(Ledger(run.folder.ledger)) as ledger:
        ledger.add_evaluation(replace(best, body={"mass": 1.0, "density": 9_000.0}))
    assert "impossibly dense matter" in said(tmp_path)


def test_parameters_at_their_bounds_are_named(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    ends = {"front_length": 3.0, "back_length": 2.995}
    values = tuple(ends.get(p.name, p.reference) for p in run.task.parameters)
    design = Design(Morphology(values), run.reward(1.0))
    run.add(design, Place(stage="coarse", index=(0, 1)), 5.0)
    told = said(tmp_path)
    assert "front_length, back_length stand at the bounds of the search" in told
    assert "the task itself allows more" not in told.lower()


def test_bounds_of_the_search_are_told_from_those_of_the_task(tmp_path: Path) -> None:
    run = FakeRun(tmp_path)
    thin = {"middle_radius": 0.01}  # the task goes down to 0.005
    values = tuple(thin.get(p.name, p.reference) for p in run.task.parameters)
    design = Design(Morphology(values), run.reward(1.0))
    run.add(design, Place(stage="coarse", index=(0, 1)), 5.0)
    told = said(tmp_path)
    assert "middle_radius stands at a bound of the search" in told
    assert "The task itself allows more" in told


@pytest.mark.parametrize(
    ("scale", "longer", "slim"), [(0.5, 1.0, True), (1.0, 1.0, False), (0.5, 1.1, False)]
)
def test_a_champion_that_is_a_slim_reference_needed_no_search(
    tmp_path: Path, scale: float, longer: float, slim: bool
) -> None:
    run = FakeRun(tmp_path)
    first, *others = run.morphology(scale).parameters
    design = Design(Morphology((longer * first, *others)), run.reward(3.0))
    best = run.add(design, Place(stage="coarse", index=(0, 1)), 31.0)
    run.final(best, found=STEADY, reference=STEADY, morphology_only=STEADY, reward_only=STEADY)
    assert ("scaled by 0.5, as --method slim-reference" in said(tmp_path)) is slim
