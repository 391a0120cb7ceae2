"""What the live view and the plain lines know of a run, told by events and a clock that is ours."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import Console

from robomore.cli.live import LiveView, PlainLines, render
from robomore.events import (
    BatchBegan,
    Finished,
    Progressed,
    Proposed,
    RunBegan,
    Spent,
    Started,
)
from robomore.monitor.progress import Progress, steps_after
from robomore.settings import Budget, RunSettings, SearchSettings
from robomore.types import (
    Design,
    Evaluation,
    Job,
    Morphology,
    Place,
    Reward,
    Slot,
    Status,
    TrainerSettings,
)

SETTINGS = RunSettings(
    search=SearchSettings(
        morphologies=2, rewards=2, survivors=0.25, max_cycles=1, finalists=1, repeats=1
    ),
    trainer=TrainerSettings(),
    candidate=Budget(1_000, 1),
    final=Budget(2_000, 1),
)
BEGAN = RunBegan(
    "ant", "quick", SETTINGS, "offline", "No LLM was used.", 3, 2, Path("runs/x"), "strict (files)"
)
GRID = tuple(Place(stage="coarse", morphology=i, reward=j) for i in range(2) for j in range(2))
FINE = Place(stage="fine", cycle=1, changed="reward")
LAST = (Place(stage="final", changed="champion"), Place(stage="final", changed="human"))


class Clock:
    """Stands still until it is set."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def measured(key: str, fitness: float, steps: int = 1_000) -> Evaluation:
    job = Job("ant", Design(Morphology((1.0,)), Reward("")), TrainerSettings(), steps, 1, 0)
    return Evaluation(
        key, job, Status.OK, fitness=fitness, volume=0.5, efficiency=2 * fitness, steps=steps
    )


def failed(key: str) -> Evaluation:
    good = measured(key, 1.0)
    return Evaluation(key, good.job, Status.REWARD_FAILED, "line 3: [bold]NameError\nmore")


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def progress(clock: Clock) -> Progress:
    """After 10 s: one of four is measured, one is half done, one failed, one waits."""
    progress = Progress(clock)
    progress(BEGAN)
    progress(Proposed(Slot("coarse", "morphology", 0, 0), "long [legs]"))
    progress(BatchBegan(GRID, known=0))
    progress(Started("a", GRID[0], 1_000))
    progress(Started("b", GRID[1], 1_000))
    clock.now += 10
    progress(Progressed("b", 500))
    progress(Finished(measured("a", 3.0), GRID[0], known=False))
    progress(Started("c", GRID[2], 1_000))
    progress(Finished(failed("c"), GRID[2], known=False))
    return progress


def test_counts_and_best(progress: Progress) -> None:
    assert (progress.finished, progress.failed, progress.open) == (2, 1, 2)
    assert list(progress.running) == ["b"]
    assert progress.best is not None
    assert progress.best[1] == GRID[0]
    progress(Finished(measured("d", 2.0), GRID[3], known=False))
    assert progress.best[1] == GRID[0]


def test_what_screening_looked_at_is_not_the_best_of_the_search(progress: Progress) -> None:
    look = Place(stage="screening", morphology=0)
    progress(Finished(measured("x", 99.0), look, known=False))
    progress(Finished(measured("y", 99.0, steps=200), GRID[3], known=False))
    assert progress.best is not None
    assert progress.best[0].key == "a"


def test_the_final_is_not_the_best_of_the_search(progress: Progress) -> None:
    progress(BatchBegan(LAST, known=0))
    progress(Finished(measured("z", 99.0), LAST[0], known=False))
    assert progress.best is not None
    assert progress.best[0].key == "a"


def test_the_best_follows_the_objective(clock: Clock) -> None:
    progress = Progress(clock)
    search = replace(SETTINGS.search, objective="fitness")
    progress(replace(BEGAN, settings=replace(SETTINGS, search=search)))
    progress(BatchBegan(GRID, known=0))
    progress(Finished(replace(measured("a", 3.0), efficiency=1.0), GRID[0], known=False))
    progress(Finished(replace(measured("b", 2.0), efficiency=9.0), GRID[1], known=False))
    assert progress.best is not None
    assert progress.best[0].key == "a"


def test_the_time_left_counts_this_batch_the_fine_stage_and_the_final(progress: Progress) -> None:
    # 1,500 steps took 2 x 10 s: 1/75 s a step. Two of the batch are left, 1,500 steps for two
    # workers of which one has a whole evaluation to do; then two half-cycles and one final round.
    remaining = progress.remaining()
    assert remaining is not None
    assert remaining.kind == "at most"
    assert remaining.seconds == pytest.approx((1_000 + 2 * 1_000 + 2_000) / 75)


def test_what_was_known_before_says_nothing_of_speed(clock: Clock) -> None:
    progress = Progress(clock)
    progress(BEGAN)
    progress(BatchBegan(GRID, known=4))
    for place in GRID:
        progress(Finished(measured("a", 1.0), place, known=True))
    assert progress.known == 4
    assert progress.remaining() is None


@pytest.mark.parametrize(
    ("stage", "half_cycles", "steps"),
    [("coarse", 0, 2_000 + 2_000), ("fine", 1, 1_000 + 2_000), ("final", 2, 0)],
)
def test_what_comes_after_a_batch(stage: str, half_cycles: int, steps: int) -> None:
    assert steps_after(SETTINGS, 2, stage, half_cycles) == steps


def test_fewer_workers_than_branches_take_turns() -> None:
    search = replace(SETTINGS.search, survivors=0.75)
    many = replace(SETTINGS, search=search)
    assert steps_after(many, 2, "coarse", 0) == 2 * 2 * 1_000 + 2_000


def shown(progress: Progress) -> str:
    screen = Console(file=io.StringIO(), width=120)
    screen.print(render(progress))
    assert isinstance(screen.file, io.StringIO)
    return screen.file.getvalue()


def test_the_live_view_shows_all_of_it_and_takes_ideas_for_text(progress: Progress) -> None:
    text = shown(progress)
    assert "No LLM was used." in text
    assert "containment: strict (files)" in text
    assert "2/4" in text
    assert "1 running, 1 failed" in text
    assert "500/1,000 steps" in text
    assert "6.000 m/m³ = 3.000 m / 0.5000 m³ (coarse: morphology 1 x reward 1)" in text
    assert "long [legs]" in text
    assert "last failure: reward-failed: line 3: [bold]NameError" in text
    assert "at most" in text


def test_the_live_view_can_be_drawn_at_any_moment(clock: Clock) -> None:
    view = LiveView(Progress(clock))
    Console(file=io.StringIO()).print(view)
    for event in (BEGAN, BatchBegan(GRID, 0), Started("a", GRID[0], 1_000), BatchBegan((FINE,), 0)):
        view(event)
        Console(file=io.StringIO()).print(view)


def test_plain_lines_tell_stages_bests_and_failures_but_not_everything(clock: Clock) -> None:
    stream = io.StringIO()
    lines = PlainLines(stream, clock)
    lines(BEGAN)
    lines(BatchBegan(GRID, 0))
    lines(Finished(measured("a", 3.0), GRID[0], known=False))
    lines(Finished(measured("b", 2.0), GRID[1], known=False))
    lines(Finished(failed("c"), GRID[2], known=False))
    clock.now += 60
    lines(Finished(measured("d", 1.0), GRID[3], known=False))
    first, provenance, contained, stage, best, failure, late = stream.getvalue().splitlines()
    assert "2 workers" in first
    assert provenance == "No LLM was used."
    assert contained == "containment: strict (files)"
    assert stage == "coarse stage: 4 evaluations"
    assert best.startswith("[coarse 1/4] best so far: 6.000")
    assert "reward-failed" in failure
    assert late.startswith("[coarse 4/4] 2.000")


def test_plain_lines_tell_of_slots_that_failed_and_now_and_then_of_the_bill(clock: Clock) -> None:
    stream = io.StringIO()
    lines = PlainLines(stream, clock)
    lines(BEGAN)
    lines(Spent(1, 500, None))
    lines(Proposed(Slot("coarse", "reward", 0, 1, attempt=2), "", "no\n\x1b[2J" + "o" * 5_000))
    clock.now += 60
    lines(Spent(12, 34_000, 0.256))
    *_, failure, spent = stream.getvalue().split("\n")[:-1]
    assert failure.startswith("coarse reward 2, attempt 3: no ") and len(failure) < 400
    assert "\x1b" not in failure
    assert spent.startswith("language model: 12 requests, 34,000 tokens, $0.26; 1 min 00 s so far")
    assert stream.getvalue().count("language model") == 1


def test_the_live_view_shows_the_bill(progress: Progress) -> None:
    console = Console(file=io.StringIO(), width=100)
    progress(Spent(3, 4_000, None))
    console.print(render(progress))
    assert "language model: 3 requests, 4,000 tokens, of unknown price" in console.file.getvalue()
