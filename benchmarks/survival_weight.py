"""How much should a reward pay for staying healthy, beside speed?

    python benchmarks/survival_weight.py [--robots walker hopper] [--weights 0 0.1 0.3 1 3]
        [--morphologies 2] [--seeds 8] [--steps 30720] [--workers 1] [--out marks.jsonl]

Morphologies that the offline designer proposes are trained for a short time: under the reference
reward, and under one of the offline designer's terms, 3 for each m/s and a bonus of some weight
for each healthy step. A ratio compares a weight with the reference reward on the same morphology
and seed; its geometric mean has a 95 % interval from a bootstrap over the seeds of each morphology.
"""

from __future__ import annotations

import argparse
import math
from collections import defaultdict
from pathlib import Path
from statistics import median

from curves import Course, follow_all
from robomore.designers.offline.morphology_sampler import MorphologySampler
from robomore.designers.offline.reward_composition import RewardComposition
from robomore.designers.offline.robot_semantics import robot_semantics
from robomore.statistics.aggregate import mean_of_all, stratified_interval
from robomore.tasks import get_task
from robomore.types import Morphology, Slot, TrainerSettings

REFERENCE = "reference"
SPEED = 3.0
FLOOR = 0.1
"""Fitness in m below which a training counts as one that did not move: ratios stay finite."""


def proposed(robot: str, count: int) -> list[Morphology]:
    """Return the first morphologies that the offline designer proposes, with seed 0."""
    sampler = MorphologySampler(get_task(robot), 0)
    found: list[Morphology] = []
    for index in range(count):
        found.append(sampler.sample(Slot("coarse", "morphology", (index,)), found))
    return found


def rewards(robot: str, weights: list[float]) -> dict[str, str]:
    """Return the texts that are compared, by label."""
    semantics = robot_semantics(get_task(robot))
    terms = {
        f"alive {weight:g}": {"forward_speed": SPEED} | ({"alive": weight} if weight else {})
        for weight in weights
    }
    own = {label: RewardComposition(one).source(semantics) for label, one in terms.items()}
    return {REFERENCE: ""} | own


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--robots", nargs="*", default=["walker", "hopper"])
    parser.add_argument("--weights", nargs="*", type=float, default=[0, 0.1, 0.3, 1, 3])
    parser.add_argument("--morphologies", type=int, default=2)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--steps", type=int, default=30_720)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    courses = [
        Course(
            robot,
            f"proposal {index}",
            morphology.parameters,
            seed,
            TrainerSettings("crossq"),
            given.steps,
            given.steps,
            text,
            label=label,
        )
        for seed in range(given.seeds)
        for robot in given.robots
        for index, morphology in enumerate(proposed(robot, given.morphologies))
        for label, text in rewards(robot, given.weights).items()
    ]
    found: dict[str, dict[tuple[str, str], dict[int, float]]] = defaultdict(
        lambda: defaultdict(dict)
    )
    for marks in follow_all(courses, given.workers, given.out):
        for mark in marks:
            found[mark.label][mark.robot, mark.morphology][mark.seed] = mark.fitness
    for label, bodies in found.items():
        for (robot, morphology), by_seed in sorted(bodies.items()):
            values = [fitness for _, fitness in sorted(by_seed.items())]
            print(
                f"{robot:<9}{morphology:<13}{label:<11}{median(values):>7.2f}  "
                + " ".join(f"{value:.2f}" for value in values)
            )
    print("\nover the reference reward, geometric mean and 95 % interval")
    reference = found.pop(REFERENCE)
    for label, bodies in found.items():
        # A training that did not end has no mark; its pair is left out.
        logs = [
            [
                math.log(max(fitness, FLOOR) / max(reference[body][seed], FLOOR))
                for seed, fitness in by_seed.items()
                if seed in reference[body]
            ]
            for body, by_seed in sorted(bodies.items())
        ]
        low, high = stratified_interval(mean_of_all, logs)
        mean = math.exp(mean_of_all(logs))
        print(f"{label:<11}{mean:>6.2f}  [{math.exp(low):.2f}, {math.exp(high):.2f}]")


if __name__ == "__main__":
    main()
