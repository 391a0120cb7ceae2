"""`robomore` as it is, but for the work of its evaluations: `python quick_run.py WORK run …`.

`quick` replaces the trainer alone, by one that takes no time; processes, sandbox, ledger and
measurement are the real ones. `made_up` makes the numbers and the policy of an evaluation from its
key, which spares a sandboxed process; all else is real. `slow` does the same in a second each.
`disk_full` finds no space to work in. Nothing moves in the reports, which would take seconds.
"""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import msgspec

FOLDERS = (Path(__file__).parent, Path(__file__).parents[1], Path(__file__).parents[1] / "hostile")
"""What the workers import: this module, `untrained.py`, and the quick trainer of `whole.py`."""
SMOKE = (
    *("run", "swimmer", "--preset", "smoke", "--seed", "1", "--quiet"),
    *("--method-option", "rewards=1", "--steps", "1024", "--final-steps", "768"),
)
"""Two robots and one reward, refined once, with a final: a run's every stage, and no more."""


def command(*arguments: str | Path, work: str = "made_up") -> list[str]:
    """Return the command line of this program."""
    return [sys.executable, str(Path(__file__)), work, *map(str, arguments)]


def environment() -> dict[str, str]:
    """Return what the program needs to find itself in its workers."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, FOLDERS))}


def ended(
    *arguments: str | Path, work: str = "made_up", seconds: float = 120
) -> subprocess.CompletedProcess[str]:
    """Run the program to its end."""
    return subprocess.run(
        command(*arguments, work=work),
        env=environment(),
        capture_output=True,
        text=True,
        timeout=seconds,
        check=False,
    )


def quick(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Do an encoded `Request` as a worker does, with the quick trainer."""
    from robomore.evaluation import evaluate
    from robomore.evaluation.work import work
    from robomore.sandbox.call import SandboxResult, run_sandboxed

    def quickly(
        function: str, *arguments: object, readable: object, **options: object
    ) -> SandboxResult:
        return run_sandboxed("whole:train", *arguments, readable=FOLDERS, **options)  # type: ignore[arg-type]

    evaluate.run_sandboxed = quickly  # type: ignore[assignment]
    evaluate.compiled_trainer = lambda shape, containment: None
    return work(payload, progress)


def made_up(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Answer an encoded `Request` with numbers and a policy that are made from its key."""
    import numpy as np

    from robomore.evaluation.request import Answer, Request
    from robomore.training.policy import MLPPolicy
    from untrained import made_up as evaluation_of

    request = msgspec.json.decode(payload, type=Request)
    weights = np.random.default_rng(int(request.key[:8], 16)).normal(size=(8, 2))
    policy = MLPPolicy((weights.astype(np.float32),), (np.zeros(2, np.float32),))
    return msgspec.json.encode(Answer(evaluation_of(request), policy.to_bytes()))


def slow(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Do the same, but not at once."""
    time.sleep(1.0)
    return made_up(payload, progress)


def disk_full(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Do an encoded `Request` on a disk that has no space for what training leaves."""
    from robomore.evaluation import evaluate
    from robomore.evaluation.work import work

    def leave(*arguments: object, **options: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    evaluate.run_sandboxed = leave  # type: ignore[assignment]
    evaluate.compiled_trainer = lambda shape, containment: None
    return work(payload, progress)


if __name__ == "__main__":
    from robomore.cli import main
    from robomore.evaluation import evaluator
    from robomore.report import page

    page.recorded = lambda run, key, name: None
    evaluator._WORK = f"quick_run:{sys.argv.pop(1)}"
    sys.exit(main())
