"""Screening against a grid that was trained to the end: what it finds again, for which steps.

    python benchmarks/screening.py [--task half-cheetah] [--steps 150000]    # from recorded numbers
    python benchmarks/screening.py --record [--workers 2]    # what it lacks: an hour of one core

The record is a grid that the offline designer proposed for a task: 25 morphologies and 5 rewards,
each pair trained to the end and measured at every fifth of the way. The search's own screening then
runs on these numbers in the place of training. A record can be stopped and gone on with;
morphologies whose pairs are not all there yet are left out. To record the grid of today's designer,
remove the CSV file first.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from scipy.stats import spearmanr

from curves import Course, follow_all
from robomore.designers import make_designer
from robomore.events import Observer, ignore
from robomore.search.measure import top
from robomore.search.method import SearchContext
from robomore.search.robomore.coarse import coarse
from robomore.search.robomore.planning import COARSE
from robomore.search.robomore.screening import screened
from robomore.search.robomore.settings import RoboMoReSettings, Rung
from robomore.settings import standard
from robomore.tasks import get_task
from robomore.tasks.task import Task
from robomore.types import (
    Design,
    Evaluation,
    Job,
    Morphology,
    Place,
    Reward,
    Status,
    Trial,
    finished,
)

DATA = Path(__file__).parent / "data"
STEPS = standard().candidate.steps
"""Of every pair in a record: what the coarse stage of `standard` would give to each."""
PARTS = 5
GRID = RoboMoReSettings(reference_reward="out", screening="halving")
"""The grid that was recorded: all five rewards are proposed ones."""


def rungs(*pairs: tuple[float, float]) -> RoboMoReSettings:
    """Return halving that keeps so much of the pairs after so much of the way.

    Each pair is the fraction of the way, and the fraction of the pairs that is kept.
    """
    return replace(GRID, rungs=tuple(Rung(*pair) for pair in pairs))


WAYS = {
    "halving (the default)": GRID,
    "20 % keep 0.25, 40 % keep 0.1": rungs((0.2, 0.25), (0.4, 0.1)),
    "20 % keep 0.3, 60 % keep 0.08": rungs((0.2, 0.3), (0.6, 0.08)),
    "20 % keep 0.15": rungs((0.2, 0.15)),
}
"""Ways to screen, by name."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--task", default="half-cheetah")
    parser.add_argument("--steps", type=int, default=STEPS, help="of every pair in the record")
    parser.add_argument("--record", action="store_true", help="train what the record lacks")
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args()
    task, path = get_task(given.task), DATA / f"grid-{given.task}-{given.steps // 1000}k.csv"
    if given.record:
        record(task, path, given.steps, given.workers)
    rows = whole([row_of(line) for line in lines(path)])
    if not rows:
        parser.error(f"{path} holds no whole morphology; record the grid with --record")
    report(task, rows)


@dataclass(frozen=True)
class Row:
    """One measurement of the record.

    Attributes:
        morphology, reward: place in the grid.
        fifth: of the way, 5 at its end.
        fitness: in m. What failed has no row.
        volume: in m^3.
    """

    morphology: int
    reward: int
    fifth: int
    fitness: float
    volume: float


def lines(path: Path) -> list[dict[str, str]]:
    """Return the record's lines by column, none if there is no record."""
    if not path.is_file():
        return []
    with path.open() as file:
        return list(csv.DictReader(file))


def row_of(line: dict[str, str]) -> Row:
    """Return a line of the record."""
    place = int(line["morphology"]), int(line["reward"]), int(line["fifth"])
    return Row(*place, float(line["fitness"]), float(line["volume"]))


def context(task: Task, observe: Observer = ignore) -> SearchContext:
    """Return what the search knows of the run."""
    reference = Design(Morphology(task.reference), Reward(task.reward))
    return SearchContext(
        task=task,
        reference=reference,
        candidate=standard().candidate,
        evaluations=125,
        observe=observe,
    )


def designs(task: Task) -> list[Trial]:
    """Return the grid that the offline designer proposes."""
    asked: list[Trial] = []

    def note(trials: Sequence[Trial], *, budget_fraction: float = 1.0) -> list[Evaluation]:
        asked.extend(trials)
        return []

    grid = replace(GRID, screening="none")
    coarse(make_designer("offline", task, seed=0), note, grid, context(task))
    return asked


def record(task: Task, path: Path, steps: int, workers: int) -> None:
    """Train what the record lacks of the grid, and write it down as it comes."""
    trainer = standard().trainer
    grid = designs(task)
    morphologies = {trial.place.index[0]: trial.design.morphology for trial in grid}
    found = [row_of(line) for line in lines(path)]
    known = {(row.morphology, row.reward) for row in found}
    wanted = [(*trial.place.index, trial.design.reward.source) for trial in grid]
    courses = [
        Course(
            task.id,
            f"{number} {reward}",
            morphologies[number].parameters,
            seed=0,
            trainer=trainer,
            steps=steps,
            every=steps // PARTS,
            reward=source,
        )
        for number, reward, source in wanted
        if (number, reward) not in known
    ]
    for count, marks in enumerate(follow_all(courses, workers, None), start=1):
        for fifth, mark in enumerate(marks, start=1):
            number, reward = map(int, mark.morphology.split())
            volume = task.volume(morphologies[number].parameters)
            found.append(Row(number, reward, fifth, mark.fitness, volume))
        print(f"\r{count} of {len(courses)} trainings", end="", flush=True)
        with path.open("w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow([field.name for field in fields(Row)])
            for row in sorted(found, key=lambda row: (row.morphology, row.reward, row.fifth)):
                place = row.morphology, row.reward, row.fifth
                writer.writerow((*place, f"{row.fitness:.6g}", f"{row.volume:.6g}"))
    print()


def whole(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of those morphologies whose pairs are all there, each to its end."""
    ended = {(row.morphology, row.reward) for row in rows if row.fifth == PARTS}
    complete = {
        number
        for number in {row.morphology for row in rows}
        if all((number, reward) in ended for reward in range(GRID.rewards))
    }
    return [row for row in rows if row.morphology in complete]


def report(task: Task, rows: Sequence[Row]) -> None:
    """Print how well each look foretells the end, and what screening finds for which steps."""
    count = len({row.morphology for row in rows})
    print(f"the grid of {task.id}, {count} morphologies and {GRID.rewards} rewards, to its end\n")
    for fifth in range(1, PARTS):
        print(
            f"rank correlation of efficiency at {fifth / PARTS:.0%} {foretold(rows, fifth):>8.2f}"
        )
    whole, rest = deviations(rows)
    print(
        f"\nlogarithm of efficiency at the end: deviation {whole:.2f}, and {rest:.2f} about what "
        "morphology and reward give each by itself"
    )
    print(
        f"\n{'':<42}{'recall':>8}{'of':>4}{'worth':>8}{'share of steps':>16}{'best one kept':>15}"
    )
    for name, way in WAYS.items():
        found, true, fraction = screen(task, rows, way)
        kept = "yes" if next(iter(true)) in found else "no"
        recall = len(set(found) & set(true)) / len(true)
        worth = sum(found.values()) / sum(true.values())
        print(f"{name:<42}{recall:>8.2f}{len(true):>4}{worth:>8.3f}{fraction:>16.3f}{kept:>15}")


def deviations(rows: Sequence[Row]) -> tuple[float, float]:
    """Return the standard deviation of the logarithm of efficiency at the end, and of its rest.

    The rest is what a sum of a number for each morphology and one for each reward leaves: the luck
    of single trainings, and what fits what. Where it is no more than seeds of one pair differ by,
    the order of pairs is mostly luck.
    """
    ends = {(r.morphology, r.reward): r.fitness / r.volume for r in rows if r.fifth == PARTS}
    grid = np.log(np.maximum(1e-9, np.array([ends[key] for key in sorted(ends)])))
    grid = grid.reshape(-1, GRID.rewards)
    rest = grid - grid.mean(1, keepdims=True) - grid.mean(0, keepdims=True) + grid.mean()
    freedom = (grid.shape[0] - 1) * (grid.shape[1] - 1)
    return float(grid.std()), float(np.sqrt((rest**2).sum() / freedom))


def foretold(rows: Sequence[Row], fifth: int) -> float:
    """Return Spearman's correlation of the pairs' efficiencies at a fifth and at the end."""
    known = {(r.morphology, r.reward, r.fifth): r.fitness / r.volume for r in rows}
    pairs = [
        (known[morphology, reward, fifth], last)
        for (morphology, reward, part), last in known.items()
        if part == PARTS and (morphology, reward, fifth) in known
    ]
    return float(spearmanr(pairs).statistic)


def screen(
    task: Task, rows: Sequence[Row], way: RoboMoReSettings
) -> tuple[dict[str, float], dict[str, float], float]:
    """Return the best that screening finds, the true best, and the fraction of the steps.

    Both are scores by key, the best first.

    Raises:
        KeyError: the record lacks a pair.
    """
    known = {(row.morphology, row.reward, row.fifth): row for row in rows}
    pairs = sorted({(row.morphology, row.reward) for row in rows})
    trials = [
        Trial(
            Design(Morphology((float(number),)), Reward(str(reward))),
            Place(stage=COARSE, index=(number, reward)),
        )
        for number, reward in pairs
    ]
    spent: dict[str, int] = {}

    def evaluate(asked: Sequence[Trial], *, budget_fraction: float = 1.0) -> list[Evaluation]:
        fifth = round(budget_fraction * PARTS)
        found = []
        for trial in asked:
            number, reward = trial.place.index
            key = f"{number}_{reward}"
            spent[key] = max(fifth, spent.get(key, 0))
            row = known.get((number, reward, fifth))
            found.append(evaluation(task, key, trial.design, row, fifth))
        return found

    objective = context(task).objective
    true = top(evaluate(trials), way.survivors, objective)
    spent.clear()
    measured = screened(evaluate, trials, way, context(task))
    best = top(finished(measured), way.survivors, objective, len(trials))
    scores = [{e.key: e.score(objective) or 0.0 for e in one} for one in (best, true)]
    return scores[0], scores[1], sum(spent.values()) / (PARTS * len(trials))


def evaluation(task: Task, key: str, design: Design, row: Row | None, fifth: int) -> Evaluation:
    """Return a record's row as the search would get it."""
    settings = standard()
    job = Job(task.id, design, settings.trainer, steps=fifth, episodes=10, seed=0)
    if row is None:
        return Evaluation(key, job, Status.TRAINING_DIVERGED, "training failed")
    efficiency = row.fitness / row.volume
    return Evaluation(
        key, job, Status.OK, fitness=row.fitness, volume=row.volume, efficiency=efficiency
    )


if __name__ == "__main__":
    main()
