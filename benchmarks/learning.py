"""How a trainer learns: fitness against steps and core-seconds, over robots and training seeds.

    python benchmarks/learning.py [--trainer crossq] [--set net_arch=[128,128]] [--seeds 3]
        [--robots hopper walker] [--morphologies human slim] [--steps 200000] [--every 25000]
        [--workers 1] [--out marks.jsonl]

The study behind the default trainer (benchmarks/README.md) is made of these tables.
"""

from __future__ import annotations

import argparse
import json
from collections import defaultdict
from pathlib import Path
from statistics import median

from curves import HUMAN_FITNESS, Course, Mark, follow_all, parameters_of, spread
from robomore.types import TrainerSettings


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--trainer", default="crossq")
    parser.add_argument("--set", nargs="*", default=[], metavar="NAME=VALUE", help="JSON values")
    parser.add_argument("--robots", nargs="*", default=list(HUMAN_FITNESS))
    parser.add_argument("--morphologies", nargs="*", default=["human"], choices=["human", "slim"])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--steps", type=int, default=200_000)
    parser.add_argument("--every", type=int, default=25_000)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    options = {name: json.loads(value) for name, value in (s.split("=", 1) for s in given.set)}
    trainer = TrainerSettings(given.trainer, options)
    courses = [
        Course(robot, name, parameters_of(robot, name), seed, trainer, given.steps, given.every)
        for robot in given.robots
        for name in given.morphologies
        for seed in range(given.first_seed, given.first_seed + given.seeds)
    ]
    found: dict[tuple[str, str], list[Mark]] = defaultdict(list)
    for number, marks in enumerate(follow_all(courses, given.workers, given.out), start=1):
        for mark in marks:
            found[mark.robot, mark.morphology].append(mark)
        print(f"\r{number} of {len(courses)} trainings", end="", flush=True)
    print()
    for (robot, name), marks in found.items():
        table(robot, name, marks)


def table(robot: str, morphology: str, marks: list[Mark]) -> None:
    """Print one robot's curve, a row for each number of steps."""
    human = morphology == "human"
    wanted = f" (the paper's Human row: {HUMAN_FITNESS[robot]} m)" if human else ""
    print(f"\n{robot}, {morphology} morphology{wanted}")
    print(f"{'steps':>9}{'core-s':>8}{'median m':>10}{'spread':>8}{'episode s':>11}  each seed, m")
    for steps in sorted({mark.steps for mark in marks}):
        here = sorted((m for m in marks if m.steps == steps), key=lambda mark: mark.seed)
        fitness = [mark.fitness for mark in here]
        print(
            f"{steps:>9}{median(m.seconds for m in here):>8.1f}{median(fitness):>10.2f}"
            f"{spread(fitness):>8.2f}{median(m.longest for m in here):>11.1f}  "
            + " ".join(f"{value:.1f}" for value in fitness)
        )


if __name__ == "__main__":
    main()
