"""A run as a process that can be struck: the parent, its workers, and their sandboxed processes."""

from __future__ import annotations

import random
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from processes import children, descendants, kill
from quick_run import SMOKE, command, environment
from run_state import rows

PATIENCE = 60.0
"""Seconds that anything may take."""


class Life:
    """One process that works on a run, from its start to whatever ends it."""

    def __init__(self, out: Path, work: str = "made_up") -> None:
        self.out = out
        self.began = time.monotonic()
        self.parent = subprocess.Popen(
            command(*SMOKE, "--workers", "2", "--out", out, work=work),
            env=environment(),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def lasts_until(self, seconds: float, step: float = PATIENCE) -> bool:
        """Wait until so long after its start, or one step; says whether it still goes on."""
        try:
            self.parent.wait(min(step, max(0.0, self.began + seconds - time.monotonic())))
        except subprocess.TimeoutExpired:
            return True
        return False

    def lasts_until_rows(self, count: int) -> None:
        """Wait until so many evaluations are in the ledger, or until it ends."""
        while len(rows(self.out)) < count and self.lasts_until(PATIENCE, step=0.02):
            continue

    def strike(self, victim: str, choose: random.Random) -> bool:
        """Kill what is named; says whether there was such a thing."""
        workers = children(self.parent.pid)
        match victim:
            case "parent":
                kill(self.parent.pid)
            case "all":
                kill(self.parent.pid, *descendants(self.parent.pid))
            case "worker" | "sandboxed":
                prey = workers if victim == "worker" else descendants(self.parent.pid)
                prey = [pid for pid in prey if victim == "worker" or pid not in workers]
                if not prey:
                    return False
                kill(choose.choice(prey))
        return True

    def end(self) -> tuple[int, str]:
        """Wait for its end; returns exit status and what it said of itself."""
        _, said = self.parent.communicate(timeout=PATIENCE)
        return self.parent.returncode, said

    def close(self) -> None:
        kill(self.parent.pid, *descendants(self.parent.pid))
        self.parent.communicate(timeout=PATIENCE)


@contextmanager
def life(out: Path, work: str = "made_up") -> Iterator[Life]:
    """Start the run; nothing of it is left afterwards."""
    begun = Life(out, work)
    try:
        yield begun
    finally:
        begun.close()


def killed_run(out: Path, count: int) -> Path:
    """Leave a run that was killed once it had measured `count` designs; returns its log."""
    with life(out) as begun:
        begun.lasts_until_rows(count)
    log = out / "ledger.sqlite-wal"
    assert log.stat().st_size
    return log
