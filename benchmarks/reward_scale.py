"""Does a reward's unit or offset change what is learnt?

    python benchmarks/reward_scale.py [--robots hopper walker] [--seeds 5] [--steps 102400]
        [--factors 0.001 1 1000] [--offsets -5 5] [--workers 1] [--out marks.jsonl]

The human designs are trained under the reference reward times a factor, or plus an offset. What is
measured is distance, so without any influence every column shows the same numbers. Offsets are
tried where an episode never ends early: elsewhere they say something else about falling.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from pathlib import Path
from statistics import median

from curves import HUMAN_FITNESS, Course, follow_all, parameters_of
from robomore.tasks import get_task
from robomore.types import TrainerSettings

FACTORS = [0.001, 0.01, 0.1, 1.0, 10.0, 100.0, 1000.0]
OFFSETS = [-5.0, 5.0]
NEVER_ENDING = ("half-cheetah", "swimmer")

CHANGED = """

def _get_rew(self, x_velocity, action):
    reward, terms = _reference(self, x_velocity, action)
    return {factor!r} * reward + {offset!r}, terms
"""


def changed(robot: str, factor: float, offset: float) -> str:
    """Return the text of the reference reward times `factor` plus `offset`."""
    reference = get_task(robot).reward.replace("def _get_rew(", "def _reference(")
    return reference + CHANGED.format(factor=factor, offset=offset)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--robots", nargs="*", default=list(HUMAN_FITNESS))
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--steps", type=int, default=102_400)
    parser.add_argument("--factors", nargs="*", type=float, default=FACTORS)
    parser.add_argument("--offsets", nargs="*", type=float, default=OFFSETS)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    courses = [
        Course(
            robot,
            "human",
            parameters_of(robot, "human"),
            seed,
            TrainerSettings("crossq"),
            given.steps,
            given.steps,
            changed(robot, factor, offset),
            label=f"+ {offset:g}" if offset else f"x {factor:g}",
        )
        for robot in given.robots
        for factor, offset in [
            *((factor, 0.0) for factor in given.factors),
            *((1.0, offset) for offset in given.offsets if robot in NEVER_ENDING),
        ]
        for seed in range(given.seeds)
    ]
    found: dict[tuple[str, str], dict[int, float]] = defaultdict(dict)
    for marks in follow_all(courses, given.workers, given.out):
        for mark in marks:
            found[mark.robot, mark.label][mark.seed] = mark.fitness
    for robot, label in dict.fromkeys((course.robot, course.label) for course in courses):
        values = [fitness for _, fitness in sorted(found[robot, label].items())]
        if values:
            print(
                f"{robot:<14}{label:<9}{median(values):>9.2f}  "
                + " ".join(f"{value:.1f}" for value in values)
            )


if __name__ == "__main__":
    main()
