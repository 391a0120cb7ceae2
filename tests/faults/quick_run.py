"""`robomore` as it is, but for the trainer, which takes no time: `python quick_run.py run …`.

Processes, containment, the ledger and the measurement are the real ones.
"""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from robomore.cli import main
from robomore.evaluation import evaluate, evaluator
from robomore.sandbox.call import SandboxResult, run_sandboxed
from robomore.sandbox.layers import strict_is_possible

STRANGERS = Path(__file__).parents[1] / "hostile"
"""Where the trainer is (`whole.py`)."""
MODE = "strict" if strict_is_possible() else "relaxed"
SMOKE = ("run", "swimmer", "--preset", "smoke", "--seed", "1", "--quiet", "--containment", MODE)


def command(*arguments: str | Path) -> list[str]:
    """Return the command line of this program."""
    return [sys.executable, str(Path(__file__)), *map(str, arguments)]


def environment() -> dict[str, str]:
    """Return what the program needs to find itself in its workers."""
    return {**os.environ, "PYTHONPATH": f"{Path(__file__).parent}{os.pathsep}{STRANGERS}"}


def ended(*arguments: str | Path, seconds: float = 120) -> subprocess.CompletedProcess[str]:
    """Run the program to its end."""
    return subprocess.run(
        command(*arguments),
        env=environment(),
        capture_output=True,
        text=True,
        timeout=seconds,
        check=False,
    )


def work(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Do an encoded `Request` as a worker does, with the quick trainer."""

    def quickly(
        function: str, *arguments: object, readable: object, **options: object
    ) -> SandboxResult:
        return run_sandboxed("whole:train", *arguments, readable=[STRANGERS], **options)  # type: ignore[arg-type]

    evaluate.run_sandboxed = quickly  # type: ignore[assignment]
    evaluate.compiled_trainer = lambda shape, containment: None
    return evaluate.work(payload, progress)


def disk_full(payload: bytes, progress: Callable[[int], None]) -> bytes:
    """Do the same on a disk that has no space for the policy."""

    def keep(policy: object, artifact: Path) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(artifact))

    evaluate._keep = keep
    return work(payload, progress)


if __name__ == "__main__":
    evaluator._WORK = "quick_run:work"
    sys.exit(main())
