"""Killed at any moment, in any part, a run goes on and ends as if nothing had happened."""

from __future__ import annotations

import random
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import children, descendants, kill, running_in
from quick_run import SMOKE, command, ended, environment
from run_state import rows, same_run

VICTIMS = ("parent", "worker", "child", "all")
KILLS = 10
"""In each of the tests."""
LATEST = 0.7
"""As a share of the time that an undisturbed run takes on this machine: one that goes on is in its
last stages by then."""
PATIENCE = 60.0


class Life:
    """One process that works on a run, from its start to whatever ends it."""

    def __init__(self, out: Path) -> None:
        self.out = out
        self.began = time.monotonic()
        self.parent = subprocess.Popen(
            command(*SMOKE, "--workers", "2", "--out", out),
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

    def strike(self, victim: str, choose: random.Random) -> bool:
        """Kill what is named; says whether there was such a thing."""
        workers = children(self.parent.pid)
        match victim:
            case "parent":
                kill(self.parent.pid)
            case "all":
                kill(self.parent.pid, *descendants(self.parent.pid))
            case "worker" | "child":
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
        self.end()


@pytest.mark.parametrize("seed", range(5))
def test_killed_at_ten_moments(
    seed: int,
    undisturbed: Path,
    undisturbed_seconds: float,
    tmp_path: Path,
    record_property: pytest.RecordProperty,
) -> None:
    choose = random.Random(seed)
    latest = LATEST * undisturbed_seconds
    struck: list[str] = []
    runs = 0
    while len(struck) < KILLS:
        out = tmp_path / f"run{runs}"
        runs += 1
        seen: dict[str, tuple[object, ...]] = {}
        for life in lives(out):
            kept = rows(out)
            assert seen.items() <= kept.items(), f"lost or done twice after {struck}"
            seen = kept
            # One death a life for those below the parent: a job whose process dies twice is
            # taken to be at fault.
            moment, victim = choose.uniform(0.0, latest), choose.choice(VICTIMS)
            for _ in range(2):
                if not life.lasts_until(moment) or not life.strike(victim, choose):
                    break
                struck.append(f"{victim} at {moment:.2f} s of run {runs}")
                if victim in ("parent", "all") or len(struck) == KILLS:
                    break
                moment, victim = choose.uniform(moment, latest), choose.choice(("parent", "all"))
            if len(struck) == KILLS:
                break
        done = ended(*SMOKE, "--workers", "2", "--out", out)
        assert done.returncode == 0, f"{done.stderr} after {struck}"
        assert seen.items() <= rows(out).items(), f"lost or done twice after {struck}"
        same_run(out, undisturbed)
        assert not running_in(out)
    record_property("struck", "; ".join(struck))
    print(f"seed {seed}: {'; '.join(struck)}")  # noqa: T201  # pytest shows it of what failed


def test_sigterm_ends_a_run_cleanly(
    undisturbed: Path, undisturbed_seconds: float, tmp_path: Path
) -> None:
    choose = random.Random(99)
    out = tmp_path / "run"
    told = 0
    for _ in range(4):
        life = Life(out)
        try:
            while not (out / "run.json").exists() and life.lasts_until(PATIENCE, step=0.05):
                continue
            began = time.monotonic() - life.began
            if life.lasts_until(began + choose.uniform(0.0, 0.5 * undisturbed_seconds)):
                life.parent.send_signal(signal.SIGTERM)
            status, said = life.end()
        finally:
            life.close()
        # Before it can catch the signal, and after its last word, it just ends.
        assert status in (130, -signal.SIGTERM, 0), said
        if status == 130:
            told += 1
            assert said.count("\n") == 1
            assert "the same command goes on from there" in said or said == "robomore: stopped\n"
        assert not running_in(out)
    assert told, "no signal came in time"
    done = ended(*SMOKE, "--workers", "2", "--out", out)
    assert done.returncode == 0, done.stderr
    same_run(out, undisturbed)


def lives(out: Path) -> Iterator[Life]:
    """Start the run over and over, until one life ends by itself."""
    while True:
        life = Life(out)
        try:
            yield life
            status, said = life.end()
        finally:
            life.close()
        if status == 0:
            return
        assert status == -signal.SIGKILL, said
