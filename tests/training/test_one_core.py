"""Training keeps to one core, and finds compiled programs where the environment says."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

from probes import SETTINGS, Cart

from robomore.training.compilation import CACHE_VARIABLE
from robomore.training.crossq import CrossQ
from robomore.training.loop import TrainingRun

_COMPILES = """
from robomore.training.compilation import use_cache
from robomore.training.threads import use_one_thread
use_one_thread()
use_cache()
import jax
jax.jit(lambda x: 2 * x + 1)(3.0)
"""


def test_training_uses_no_more_than_one_core() -> None:
    cart = Cart()
    run = TrainingRun(CrossQ(SETTINGS), SETTINGS, cart, 1)
    while run.updates < 8:
        run.advance()
    wall, cpu = time.perf_counter(), time.process_time()
    while time.perf_counter() < wall + 0.5:
        run.advance()
    assert time.process_time() - cpu < 1.1 * (time.perf_counter() - wall)


def test_compiled_programs_are_kept(tmp_path: Path) -> None:
    environment = {**os.environ, CACHE_VARIABLE: str(tmp_path)}
    subprocess.run([sys.executable, "-c", _COMPILES], env=environment, check=True)
    kept = sorted(tmp_path.iterdir())
    assert kept
    written = [path.stat().st_mtime_ns for path in kept]
    subprocess.run([sys.executable, "-c", _COMPILES], env=environment, check=True)
    assert [path.stat().st_mtime_ns for path in sorted(tmp_path.iterdir())] == written
