"""Core-seconds to the paper's Human fitness on the five robots: ours against SB3's SAC.

    python benchmarks/training.py [--robots hopper ant] [--seeds 3] [--workers 1]

Ours is the default trainer under the reference reward: trained in the open, measured at intervals,
until the median over seeds has reached the paper's Human row. The other side is the paper's: SAC of
Stable-Baselines3 with the paper's settings in the same environments, for the paper's 1e6 steps. Its
time a step is measured in this run, after its warm-up, and multiplied; what it learns is not.
Needs the extra `sb3`. Compiling and measuring are in neither number.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from statistics import median

from curves import HUMAN_FITNESS, Course, Mark, follow_all, open_trainer, spread
from robomore.settings import standard
from robomore.tasks import get_task
from robomore.types import TrainerSettings

PAPER_STEPS = 1_000_000
EVERY = 12_800
WARM_UP = 1_024
SHORT, LONG = 2_048, 8_192
"""Steps of two trainings whose difference is all learning."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--robots", nargs="*", default=list(HUMAN_FITNESS))
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--steps", type=int, default=standard().final.steps, help="at most")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    trainer = standard().trainer
    print("core-seconds to the paper's Human fitness, under the reference reward")
    print(
        f"{'':<14}{'Human':>8} |{'RoboMoRe:':>10}"
        f"{'steps':>9}{'core-s':>8}{'slowest':>9}{'spread':>8}"
        f" |{'SB3: ms':>9}{'core-s for 1e6':>16} |{'ratio':>7}"
    )
    for robot in given.robots:
        theirs = 1e-3 * sb3_milliseconds(robot) * PAPER_STEPS
        courses = [
            Course(
                robot,
                "human",
                get_task(robot).reference,
                seed,
                trainer,
                given.steps,
                EVERY,
                until=HUMAN_FITNESS[robot],
            )
            for seed in range(given.seeds)
        ]
        curves = list(follow_all(courses, given.workers, given.out))
        report(robot, curves, theirs)


def report(robot: str, curves: list[list[Mark]], theirs: float) -> None:
    """Print one robot's line; each curve ends where its training had reached the wanted fitness."""
    wanted = HUMAN_FITNESS[robot]
    ends = [marks[-1] for marks in curves if marks and marks[-1].fitness >= wanted]
    if 2 * len(ends) <= len(curves):
        print(f"{robot:<14}{wanted:>8.2f} | reached by {len(ends)} of {len(curves)} seeds only")
        return
    # A seed that never gets there is slower than all that do.
    never = [float("inf")] * (len(curves) - len(ends))
    seconds = [*(mark.seconds for mark in ends), *never]
    steps = [*(float(mark.steps) for mark in ends), *never]
    print(
        f"{robot:<14}{wanted:>8.2f} |{'':>10}{median(steps):>9.0f}{median(seconds):>8.1f}"
        f"{max(seconds):>9.1f}{spread(m.fitness for m in ends):>8.2f}"
        f" |{1e3 * theirs / PAPER_STEPS:>9.2f}{theirs:>16.0f} |{theirs / median(seconds):>6.0f}x",
        flush=True,
    )


def sb3_milliseconds(robot: str) -> float:
    """Return core-milliseconds of one control step with its share of learning."""
    times = []
    for steps in (SHORT, LONG):
        settings = TrainerSettings("sb3", {"learning_starts": WARM_UP})
        trainer, environment = open_trainer(get_task(robot), get_task(robot).reference, settings)
        began = time.process_time()
        trainer.train(environment, steps, seed=0)
        times.append(time.process_time() - began)
    return 1e3 * (times[1] - times[0]) / (LONG - SHORT)


if __name__ == "__main__":
    main()
