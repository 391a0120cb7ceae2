"""One whole candidate, as a run does it: core-seconds, memory, and how well two share a machine.

    python benchmarks/candidate.py [--task half-cheetah] [--preset standard] [--seeds 3]
        [--pairs 3]

Each candidate is `robomore evaluate` in a process of its own: checked, trained in a sandboxed
process, measured. Compiling is paid by the first one, whose cache is new, and by none after it.
Alone and side by side take turns, so that a machine that changes its pace changes both.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from statistics import median
from typing import Any

from robomore.training.threads import ONE_THREAD


@dataclass(frozen=True)
class Cost:
    """What a candidate took.

    Attributes:
        core_seconds: of all its processes.
        wall_seconds: from start to end.
        megabytes: most that one of its processes held at once.
        fitness: in m.
    """

    core_seconds: float
    wall_seconds: float
    megabytes: float
    fitness: float


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--task", default="half-cheetah")
    parser.add_argument("--preset", default="standard")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--pairs", type=int, default=3, help="turns of one alone and two at once")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as cache:
        os.environ.update(ONE_THREAD, ROBOMORE_CACHE=cache)
        command = [sys.executable, "-m", "robomore", "evaluate", given.task]
        command += ["--preset", given.preset, "--json"]
        print(f"{given.task}, reference design, preset {given.preset}")
        print(f"{'':<22}{'core-s':>8}{'wall s':>8}{'MiB':>7}{'fitness m':>11}")
        costs = []
        for seed in range(given.seeds):
            (cost,) = side_by_side([*command, "--seed", str(seed)])
            costs.append(cost)
            line(f"seed {seed}" + (", compiles first" if not seed else ""), cost)
        print(f"{'median':<30}{'':>15}{median(cost.fitness for cost in costs):>11.1f}\n")
        alone, shared = [], []
        for _ in range(given.pairs):
            alone += [cost.wall_seconds for cost in side_by_side(command)]
            shared.append(max(cost.wall_seconds for cost in side_by_side(command, command)))
        if alone:
            print(
                f"two side by side on {len(os.sched_getaffinity(0))} cores: "
                f"{median(shared):.1f} s, one alone: {median(alone):.1f} s, "
                f"ratio {median(shared) / median(alone):.2f}"
            )


def side_by_side(*commands: list[str]) -> list[Cost]:
    """Run commands at the same time; return what each took."""
    running: dict[int, tuple[int, float, Any]] = {}
    for number, command in enumerate(commands):
        # What it says fits the pipe, so it need not be read before the end.
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        running[process.pid] = number, time.perf_counter(), process.stdout
    costs: dict[int, Cost] = {}
    while running:
        # The usage of a process counts those of its children that it waited for.
        pid, _, usage = os.wait3(0)
        number, began, out = running.pop(pid)
        wall = time.perf_counter() - began
        with out:
            told = json.loads(out.read())
        if told["status"] != "ok":
            raise SystemExit(f"{told['status']}: {told['diagnosis']}")
        costs[number] = Cost(
            usage.ru_utime + usage.ru_stime, wall, usage.ru_maxrss / 1024, told["fitness"]
        )
    return [costs[number] for number in sorted(costs)]


def line(name: str, cost: Cost) -> None:
    """Print one candidate's line."""
    print(
        f"{name:<22}{cost.core_seconds:>8.1f}{cost.wall_seconds:>8.1f}{cost.megabytes:>7.0f}"
        f"{cost.fitness:>11.1f}",
        flush=True,
    )


if __name__ == "__main__":
    main()
