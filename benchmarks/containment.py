"""What containment costs a candidate, part by part and as a whole.

    python benchmarks/containment.py
    python benchmarks/containment.py --task ant --preset quick --repeats 12

The parts are the least of many tries, which a busy machine blurs little. The whole is the same
training in a sandboxed process and in a plain process at the same time, so that whatever slows down
one of them slows down the other too. The costs include the parent's, and the ratio is taken of each
pair. It needs two cores to itself to be precise; the interval says how precise it is.
"""

from __future__ import annotations

import argparse
import os
import random
import statistics
import subprocess
import sys
import tempfile
import time
import timeit
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage

from robomore.sandbox import heartbeat
from robomore.sandbox.call import SandboxResult, process_environment, run_sandboxed
from robomore.types import Limits, Status

WATCHED_SECONDS = 4.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--task", default="ant")
    parser.add_argument("--preset", default="quick")
    parser.add_argument("--steps", type=int, help="of training, instead of the preset's")
    parser.add_argument("--repeats", type=int, default=0, help="of the whole; 0 leaves it out")
    options = parser.parse_args()
    costs = parts()
    if options.repeats:
        whole(options, costs)


@dataclass(frozen=True)
class Parts:
    """Of the cost: seconds of core once, a share of the time, and seconds for each call."""

    starting: float
    watching: float
    calling: float


def parts() -> Parts:
    """Print what starting, watching and each reward call cost."""
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        bare = [sys.executable, "-P", "-s", "-c", "import json, numpy"]
        environment = process_environment(scratch)
        plain = [
            _cost(lambda: subprocess.run(bare, check=True, env=environment))[0] for _ in range(20)
        ]
        sandboxed = [_cost(lambda: _checked("nothing", b"", scratch))[0] for _ in range(20)]
        starting = min(sandboxed) - min(plain)
        print(f"starting: {1e3 * starting:.0f} ms of core more")

        before = time.process_time()
        _checked("busy", str(WATCHED_SECONDS).encode(), scratch)
        watching = (time.process_time() - before) / WATCHED_SECONDS
        print(f"watching: {100 * watching:.2f} % of one core")

    def reward(simulation: object, x_velocity: object, action: object) -> tuple[float, dict]:
        return 0.0, {}

    with heartbeat.page() as page:
        heartbeat.attach(page)
        counted = heartbeat.watch(reward)
    calls = 200_000
    times = [
        min(timeit.repeat(lambda f=f: f(None, 0.0, None), number=calls, repeat=7))
        for f in (reward, counted)
    ]
    calling = (times[1] - times[0]) / calls
    print(f"each reward call: {1e9 * calling:.0f} ns more")
    return Parts(starting, watching, calling)


def whole(options: argparse.Namespace, costs_of: Parts) -> None:
    """Print what the same training costs sandboxed and plain."""
    import msgspec

    from robomore.envs.vector_env import VectorEnv
    from robomore.evaluation.compiled import compiled_trainer
    from robomore.evaluation.request import Request
    from robomore.sandbox.call import Containment
    from robomore.settings import preset
    from robomore.tasks import get_task
    from robomore.training.compilation import CACHE_VARIABLE
    from robomore.training.warm import Shape
    from robomore.types import Design, Job, Morphology, Reward

    task, settings = get_task(options.task), preset(options.preset)
    job = Job(
        task.id,
        Design(Morphology(task.reference), Reward(task.reward)),
        settings.trainer,
        steps=options.steps or settings.candidate.steps,
        episodes=1,
        seed=0,
    )
    robot = VectorEnv(task, task.reference, 1)
    shape = Shape(job.trainer, robot.observation_size, robot.action_size)
    compiled = compiled_trainer(shape, Containment.STRICT)
    extra = {CACHE_VARIABLE: str(compiled)} if compiled else {}
    print(f"{job.task}, {job.steps:,} steps, trainer compiled before: {compiled is not None}")

    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        payload = msgspec.json.encode(Request(job, key="", scratch=folder))

        def sandboxed() -> float:
            readable = [compiled] if compiled else []
            ended = run_sandboxed(
                "robomore.evaluation.train:train",
                payload,
                scratch / "sandboxed",
                Limits(),
                readable=readable,
                environment=extra,
            )
            _answered(ended)
            return ended.seconds

        def plain() -> float:
            child = subprocess.Popen(
                [sys.executable, "-P", "-s", "-c", _PLAIN, str(scratch / "plain")],
                stdin=subprocess.PIPE,
                cwd=scratch / "plain",
                env=process_environment(scratch) | extra,
            )
            assert child.stdin is not None
            child.stdin.write(payload)
            child.stdin.close()
            _, status, used = os.wait4(child.pid, 0)
            if status:
                sys.exit(f"the plain training failed ({status})")
            child.returncode = status
            return used.ru_utime + used.ru_stime

        for way in ("sandboxed", "plain"):
            (scratch / way).mkdir()
        pairs = []
        with ThreadPoolExecutor(2) as side_by_side:
            for _ in range(options.repeats):
                both = [side_by_side.submit(_own_cost, way) for way in (plain, sandboxed)]
                (core, wall), (core_sandboxed, wall_sandboxed) = (one.result() for one in both)
                pairs.append((core, wall, core_sandboxed, wall_sandboxed))
                print(
                    "plain {:.2f} s of core, {:.2f} s; sandboxed {:.2f}, {:.2f}".format(*pairs[-1])
                )
    least = _least(pairs, 0)
    # As if the reward were called in every control step, which most are not.
    sum_of_parts = costs_of.starting + costs_of.watching * least + costs_of.calling * job.steps
    print(f"core seconds, by the parts above: {1 + sum_of_parts / least:.4f} of plain")
    for name, before, after in (("core", 0, 2), ("wall-clock", 1, 3)):
        ratios = [pair[after] / pair[before] for pair in pairs]
        low, high = _interval(ratios)
        sums = sum(pair[after] for pair in pairs) / sum(pair[before] for pair in pairs)
        print(
            f"{name} seconds, sandboxed over plain: {statistics.median(ratios):.4f} in the median "
            f"of {len(ratios)} pairs (95 % interval {low:.4f} to {high:.4f}), {sums:.4f} in total, "
            f"least over least {_least(pairs, after) / _least(pairs, before):.4f}"
        )


def _interval(values: list[float]) -> tuple[float, float]:
    """Return the 95 % bootstrap interval of the median."""
    draw = random.Random(0)
    medians = sorted(statistics.median(draw.choices(values, k=len(values))) for _ in range(4_000))
    return medians[100], medians[-101]


def _least(pairs: list[tuple[float, ...]], column: int) -> float:
    return min(pair[column] for pair in pairs)


def nothing(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Run in a child: import what the bare process imports."""
    import numpy

    return numpy.__name__.encode()


def busy(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Run in a child: compute for some seconds and report as a trainer does."""
    ends = time.monotonic() + float(payload)
    step = 0
    while time.monotonic() < ends:
        step += sum(n * n for n in range(2_000_000)) % 2 + 1
        report(step)
    return b""


_PLAIN = """
import os, sys
from pathlib import Path
from types import ModuleType
sys.modules["glfw"] = ModuleType("glfw")
from robomore.evaluation.train import train
train(sys.stdin.buffer.read(), Path(sys.argv[1]), lambda steps: None)
os._exit(0)  # as the sandboxed process does: neither pays for what libraries clean up
"""


def _checked(function: str, payload: bytes, scratch: Path) -> None:
    _answered(
        run_sandboxed(
            f"containment:{function}", payload, scratch, Limits(), readable=[Path(__file__).parent]
        )
    )


def _answered(result: SandboxResult) -> None:
    if result.status is not Status.OK:
        sys.exit(result.diagnosis)


def _cost(action: Callable[[], object]) -> tuple[float, float]:
    """Return core-seconds, of this process and its children, and wall-clock seconds."""
    began, before = time.perf_counter(), _core_seconds()
    action()
    return _core_seconds() - before, time.perf_counter() - began


def _own_cost(action: Callable[[], float]) -> tuple[float, float]:
    """Return core-seconds, of this thread and of the child whose own `action` returns, and
    wall-clock seconds."""
    began, before = time.perf_counter(), time.thread_time()
    of_child = action()
    return of_child + time.thread_time() - before, time.perf_counter() - began


def _core_seconds() -> float:
    used = [getrusage(whose) for whose in (RUSAGE_SELF, RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


if __name__ == "__main__":
    main()
