"""What orchestration costs, and how well searches fill a large machine. Nothing is trained.

    python benchmarks/orchestration.py cost --evaluations 100 10000 100000
    python benchmarks/orchestration.py standard
    python benchmarks/orchestration.py study --seeds 5

`cost` runs a search with instant evaluations through the same parts as a real run: method,
evaluator, executor, ledger and the state of the live view. It prints processor time for each
evaluation, the memory of the whole process, and how long the live view takes to draw itself.

`standard` and `study` record which trainings a run of the preset `standard`, or each run of the
study `comparison`, asks for in which batches. This does not depend on timing. Then they play these
batches on simulated machines: the first free worker takes the next training. They print the time
against two bounds: all work shared out evenly, and the longest chain of trainings that wait for one
another, which no number of workers shortens.
"""

from __future__ import annotations

import argparse
import heapq
import resource
import time
from collections import deque
from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec
import numpy as np
from rich.console import Console

from robomore.cli.live import render
from robomore.designers import make_designer
from robomore.designers.absent import NoDesigner
from robomore.evaluation.evaluator import Evaluator
from robomore.evaluation.request import Answer, Request
from robomore.events import Event, Finished, RunBegan
from robomore.executors.executor import Done, Outcome, Progress, never
from robomore.identity import derive_seed
from robomore.monitor import RunState
from robomore.options import with_options
from robomore.plan import Plan
from robomore.search import SearchContext, final, make_method
from robomore.search.budget import BudgetedEvaluate, BudgetSpent
from robomore.search.final import stage as final_stage
from robomore.settings import RunSettings, preset
from robomore.store import Ledger, RunFolder
from robomore.studies import STUDIES
from robomore.studies.execute import cells_of
from robomore.studies.presets import scale
from robomore.tasks import Task, get_task
from robomore.training.policy import MLPPolicy
from robomore.types import Design, Evaluation, Job, Morphology, Reward, Status

SPREAD = 0.15
"""Standard deviation of the logarithm of a training's time."""
BROKEN = 0.05
"""Share of trainings that fail, after a tenth of their time."""
SECONDS_PER_STEP = 0.4e-3
PATIENCE = 3.0
"""A training that takes so many times its time is copied to a free worker, as `Ray` does."""
WORKERS = (2, 8, 16, 32, 64, 128, 256, 512, 1024)

POLICY = MLPPolicy((np.zeros((1, 1), np.float32),), (np.zeros(1, np.float32),)).to_bytes()
"""Nobody looks at it."""


class Instant:
    """An executor that trains nothing and notes what it was asked for, batch by batch."""

    workers = 64

    def __init__(self) -> None:
        self.batches: list[list[Job]] = []

    def map(
        self,
        function: str,
        payloads: Sequence[bytes],
        progress: Progress,
        timeout: float,
        should_stop: Callable[[], bool] = never,
    ) -> Generator[tuple[int, Outcome]]:
        jobs: list[Job] = []
        self.batches.append(jobs)
        for index, payload in enumerate(payloads):
            request = msgspec.json.decode(payload, type=Request)
            jobs.append(request.job)
            progress(index, 0)
            yield (
                index,
                Done(msgspec.json.encode(Answer(made_up(request.key, request.job), POLICY))),
            )

    def close(self) -> None:
        """Nothing to stop."""


def made_up(key: str, job: Job) -> Evaluation:
    """Return an evaluation whose fitness follows from what was trained, and not from for how long.

    So a design that screening keeps is good to the end, as it mostly is.
    """
    chance = np.random.default_rng(job.seed)
    if chance.random() < BROKEN:
        return Evaluation(key, job, Status.REWARD_FAILED, "made to fail", seconds=1.0)
    volume = get_task(job.task).volume(job.design.morphology.parameters)
    fitness = float(chance.lognormal())
    return Evaluation(
        key,
        job,
        Status.OK,
        fitness=fitness,
        volume=volume,
        efficiency=fitness / volume,
        behaviour={"forward_distance_m": fitness, "energy_j": 1.0},
        body={"mass": 1.0, "density": 1000.0},
        steps=job.steps,
    )


def searched(
    task: Task,
    settings: RunSettings,
    seed: int,
    folder: Path,
    observe: Callable[[Event], None],
    budget_steps: int | None = None,
) -> Instant:
    """Run a search and its final as `robomore.run` does, without its page and its checks."""
    executor = Instant()
    method = make_method(settings.method)
    context = SearchContext(
        task=task,
        reference=Design(Morphology(task.reference), Reward(task.reward)),
        candidate=settings.candidate,
        evaluations=settings.evaluations,
        objective=settings.objective,
        seed=seed,
    )
    designer = NoDesigner("")
    if method.needs_designer:
        designer = make_designer("offline", task, seed, settings.objective)
    plan = Plan((*method.plan(context).stages, final_stage(settings.final)))
    folder.mkdir(parents=True)
    with closing(Ledger(folder / "ledger.sqlite")) as ledger:
        observe(
            RunBegan(
                task=task.id,
                preset="",
                settings=settings,
                plan=plan,
                designer="",
                provenance="",
                seed=seed,
                workers=executor.workers,
                folder=folder,
                containment="",
            )
        )
        evaluator = Evaluator(
            task=task,
            trainer=settings.trainer,
            seed=seed,
            versions={},
            ledger=ledger,
            folder=RunFolder(folder),
            executor=executor,
            observe=observe,
        )
        measure = partial(evaluator.measure, budget=settings.candidate)
        evaluate = BudgetedEvaluate(measure, settings.candidate, budget_steps)
        try:
            best = method.run(designer, evaluate, context)
        except BudgetSpent:
            best = evaluate.best(settings.objective)
        if not best:
            return executor
        final(
            partial(evaluator.measure, budget=settings.final),
            best[: settings.final.finalists],
            context.reference,
            settings.final.seeds,
            settings.objective,
        )
    return executor


def cost(evaluations: int) -> None:
    """Print what one evaluation costs in a search of that many."""
    settings = with_options(
        preset("smoke"), method="random", method_options={"samples": evaluations}
    )
    state, console = RunState(), Console(width=80, quiet=True)
    drawn: list[float] = []
    every = max(1, evaluations // 20)

    def observe(event: Event) -> None:
        state(event)
        if isinstance(event, Finished) and state.counts.total() % every == 0:
            began = time.thread_time()
            console.print(render(state))
            drawn.append(time.thread_time() - began)

    with TemporaryDirectory() as folder:
        began = time.process_time()
        searched(get_task("swimmer"), settings, 0, Path(folder) / "run", observe)
        seconds = time.process_time() - began
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{evaluations:7,} evaluations: {1000 * seconds / evaluations:5.2f} ms each, "
        f"{peak:5.0f} MiB at the peak, the live view is drawn in "
        f"{1000 * float(np.median(drawn)):.1f} ms ({1000 * max(drawn):.1f} at most)"
    )


@dataclass(frozen=True, slots=True, order=True)
class Training:
    """One training, or the rest of one that screening paused.

    Attributes:
        seconds: that it takes one worker.
        name: the same for all parts of a training.
        continues: whether it goes on from a checkpoint.
    """

    seconds: float
    name: int
    continues: bool


@dataclass(frozen=True)
class Recorded:
    """What a run asks for, batch by batch."""

    batches: tuple[tuple[Training, ...], ...]

    @property
    def work(self) -> float:
        """Seconds of one worker."""
        return sum(one.seconds for batch in self.batches for one in batch)

    @property
    def chain(self) -> float:
        """Seconds that it takes with any number of workers."""
        return sum(max(one.seconds for one in batch) for batch in self.batches)


def recorded(task: Task, settings: RunSettings, seed: int, budget: int | None = None) -> Recorded:
    """Return what a run asks for. What goes on from a checkpoint counts for the rest alone."""
    with TemporaryDirectory() as folder:
        executor = searched(task, settings, seed, Path(folder) / "run", lambda event: None, budget)
    trained: dict[int, int] = {}
    batches = [tuple(_training(job, trained) for job in jobs) for jobs in executor.batches if jobs]
    return Recorded(tuple(batches))


def _training(job: Job, trained: dict[int, int]) -> Training:
    before = trained.get(job.seed, 0)
    trained[job.seed] = job.steps
    chance = np.random.default_rng(derive_seed(job.seed, "time"))
    broken = np.random.default_rng(job.seed).random() < BROKEN
    pace = float(np.exp(SPREAD * chance.standard_normal())) * (0.1 if broken else 1.0)
    seconds = SECONDS_PER_STEP * (job.steps - before) * pace
    return Training(seconds, job.seed, continues=before > 0)


def makespan(
    runs: Sequence[Recorded], workers: int, slow: float = 1.0, pinned: int | None = None
) -> float:
    """Return how long it takes until the last run ends.

    Args:
        runs: that go on side by side; each asks for its next batch when the last one is done.
        workers: that they share.
        slow: factor of the time that one eighth of the workers take, at least one of them.
        pinned: workers of one machine, if a training goes on only where it was paused.
    """
    next_batch = [iter(run.batches) for run in runs]
    missing = [0] * len(runs)
    waiting: deque[tuple[int, Training]] = deque()
    idle = list(range(workers))
    events: list[tuple[float, int, int, int, Training]] = []
    numbers, over = count(), set[int]()
    machine: dict[int, int] = {}
    now = 0.0

    def ask(run: int) -> None:
        batch = next(next_batch[run], ())
        missing[run] = len(batch)
        waiting.extend((run, training) for training in batch)

    def taker(training: Training) -> int | None:
        """Return the place among the idle of the worker that takes a training."""
        if pinned is None or not training.continues:
            return len(idle) - 1
        own = machine[training.name]
        return next((n for n, worker in enumerate(idle) if worker // pinned == own), None)

    def give(run: int, training: Training, worker: int, number: int) -> None:
        factor = slow if worker < max(1, workers // 8) else 1.0
        heapq.heappush(events, (now + factor * training.seconds, number, worker, run, training))
        if factor > PATIENCE:
            heapq.heappush(events, (now + PATIENCE * training.seconds, number, -1, run, training))

    def start() -> None:
        for _ in range(len(waiting)):
            if not idle:
                return
            run, training = waiting.popleft()
            place = taker(training)
            if place is None:
                waiting.append((run, training))
                continue
            worker = idle.pop(place)
            if pinned is not None:
                machine[training.name] = worker // pinned
            give(run, training, worker, next(numbers))

    for run in range(len(runs)):
        ask(run)
    start()
    while events:
        moment, number, worker, run, training = heapq.heappop(events)
        if number in over:
            if worker >= 0:  # It was given up when the other one was done.
                idle.append(worker)
                start()
            continue
        now = moment
        if worker < 0:
            if not waiting and idle:
                quickest = max(idle)
                idle.remove(quickest)
                give(run, training, quickest, number)
            continue
        over.add(number)
        idle.append(worker)
        missing[run] -= 1
        if not missing[run]:
            ask(run)
        start()
    return now


def told(runs: Sequence[Recorded]) -> None:
    """Print how well any number of workers is used."""
    work, chain = sum(run.work for run in runs), max(run.chain for run in runs)
    trainings = sum(len(batch) for run in runs for batch in run.batches)
    print(
        f"{len(runs)} runs, {trainings:,} trainings, {work / 3600:.1f} core-hours, longest chain "
        f"{chain / 60:.1f} min; it alone keeps {work / chain:.0f} workers busy on average"
    )
    print("workers   hours  of work/workers  of the bound  one of 8 ten times slower  pinned")
    for workers in WORKERS:
        took, slowed = makespan(runs, workers), makespan(runs, workers, slow=10.0)
        held = f"{makespan(runs, workers, pinned=8) / 3600:6.2f} h" if len(runs) == 1 else ""
        bound = max(work / workers, chain)
        print(
            f"{workers:7} {took / 3600:7.2f} {work / workers / took:16.0%} {bound / took:13.0%} "
            f"{slowed / 3600:24.2f} h {held}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["cost", "standard", "study"])
    parser.add_argument("--evaluations", type=int, nargs="+", default=[100, 10_000])
    parser.add_argument("--preset", default="standard")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--tasks", nargs="*", default=["ant", "half-cheetah", "hopper", "swimmer"])
    given = parser.parse_args()
    if given.what == "cost":
        for evaluations in given.evaluations:
            cost(evaluations)
        return
    if given.what == "standard":
        task = get_task(given.tasks[0])
        told([recorded(task, preset(given.preset), 0)])
        return
    size = scale(given.preset)
    cells = cells_of(STUDIES.get("comparison"), given.tasks, size, given.seeds)
    told([recorded(get_task(c.task), c.settings, c.seed, c.budget_steps) for c in cells])


if __name__ == "__main__":
    main()
