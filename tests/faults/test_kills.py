"""Killed at any moment, in any part, a run goes on and ends as if nothing had happened."""

from __future__ import annotations

import random
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from lives import PATIENCE, Life, life
from processes import running_in
from quick_run import SMOKE, ended
from run_state import rows, same_run

VICTIMS = ("parent", "worker", "sandboxed", "all")
FEW, MANY = 2, 10
"""Kills in a test that always runs, and in one of the exhaustive ones."""
LATEST = 0.7
"""As a share of the time that an undisturbed run takes on this machine: one that goes on is in its
last stages by then."""


@pytest.mark.parametrize(
    ("seed", "kills"),
    [(0, FEW), *(pytest.param(seed, MANY, marks=pytest.mark.exhaustive) for seed in range(5))],
)
def test_killed_at_any_moment(
    seed: int, kills: int, trained: Path, tmp_path: Path, record_property: pytest.RecordProperty
) -> None:
    choose = random.Random(seed)
    latest = LATEST * float((trained / "seconds").read_text())
    struck: list[str] = []
    runs = 0
    while len(struck) < kills:
        out = tmp_path / f"run{runs}"
        runs += 1
        seen: dict[str, tuple[object, ...]] = {}
        for begun in lives(out):
            kept = rows(out)
            assert seen.items() <= kept.items(), f"lost or done twice after {struck}"
            seen = kept
            # One death a life for those below the parent: a job whose process dies twice is
            # taken to be at fault.
            moment, victim = choose.uniform(0.0, latest), choose.choice(VICTIMS)
            for _ in range(2):
                if not begun.lasts_until(moment) or not begun.strike(victim, choose):
                    break
                struck.append(f"{victim} at {moment:.2f} s of run {runs}")
                if victim in ("parent", "all") or len(struck) == kills:
                    break
                moment, victim = choose.uniform(moment, latest), choose.choice(("parent", "all"))
            if len(struck) == kills:
                break
        done = ended(*SMOKE, "--workers", "2", "--out", out, work="quick")
        assert done.returncode == 0, f"{done.stderr} after {struck}"
        assert seen.items() <= rows(out).items(), f"lost or done twice after {struck}"
        same_run(out, trained / "run")
        assert not running_in(out)
    record_property("struck", "; ".join(struck))
    print(f"seed {seed}: {'; '.join(struck)}")  # noqa: T201  # pytest shows it of what failed


def test_sigterm_ends_a_run_cleanly(trained: Path, tmp_path: Path) -> None:
    choose = random.Random(99)
    out = tmp_path / "run"
    caught = 0
    for _ in range(2):
        if caught:
            break
        with life(out, "quick") as begun:
            while not (out / "run.json").exists() and begun.lasts_until(PATIENCE, step=0.05):
                continue
            passed = time.monotonic() - begun.began
            rest = 0.5 * float((trained / "seconds").read_text())
            if begun.lasts_until(passed + choose.uniform(0.0, rest)):
                begun.parent.send_signal(signal.SIGTERM)
            status, said = begun.end()
        # Before it can catch the signal, and after its last word, it just ends.
        assert status in (130, -signal.SIGTERM, 0), said
        if status == 130:
            caught += 1
            assert said.count("\n") == 1
            assert "the same command goes on from there" in said or said == "robomore: stopped\n"
        assert not running_in(out)
    assert caught, "no signal came in time"
    done = ended(*SMOKE, "--workers", "2", "--out", out, work="quick")
    assert done.returncode == 0, done.stderr
    same_run(out, trained / "run")


def lives(out: Path) -> Iterator[Life]:
    """Start the run over and over, until one life ends by itself."""
    while True:
        with life(out, "quick") as begun:
            yield begun
            status, said = begun.end()
        if status == 0:
            return
        assert status == -signal.SIGKILL, said
