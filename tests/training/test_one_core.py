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
import sys
import numpy as np
from robomore.training.compilation import compiled

def double(x):
    print("traced")
    return 2 * x + float(sys.argv[1])

x = np.arange(3, dtype=np.float32)
print(compiled("double " + sys.argv[1], double, x)(x))
print(compiled("double " + sys.argv[1], double, x)(x))
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

    def printed(offset: int) -> list[str]:
        command = [sys.executable, "-c", _COMPILES, str(offset)]
        done = subprocess.run(
            command, env=environment, check=True, stdout=subprocess.PIPE, text=True
        )
        return done.stdout.splitlines()

    assert printed(1) == ["traced", "[1. 3. 5.]", "[1. 3. 5.]"]
    assert len(list(tmp_path.iterdir())) == 1
    assert printed(1) == ["[1. 3. 5.]", "[1. 3. 5.]"], "not traced again"
    assert printed(2) == ["traced", "[2. 4. 6.]", "[2. 4. 6.]"], "another function"
    for half in tmp_path.iterdir():
        content = half.read_bytes()
        half.write_bytes(content[:1000] + bytes(64) + content[1064:])
    assert printed(2) == ["traced", "[2. 4. 6.]", "[2. 4. 6.]"], "damaged"
