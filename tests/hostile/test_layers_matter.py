"""The suite can fail: without the layers the same programs do get out, and the world notices."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from attempts import attempts
from world import encode, world

from robomore.sandbox.call import SandboxResult
from robomore.types import Status

# Harmless where nothing holds them: they read, write and reach what is planted for them.
REAL = (
    *("read/open", "read/fromfile", "read/environment", "read/load_pickle", "read/symbolic_link"),
    *("write/outside", "write/ledger_by_sqlite", "write/lock_out", "write/times"),
    *("network/tcp", "network/udp", "network/unix", "network/unix_abstract", "process/system"),
)

_UNPROTECTED = """
import sys
sys.path.insert(0, {folder!r})
from pathlib import Path
from miniature import train
try:
    train(sys.stdin.buffer.read(), Path("."), lambda n: None)
except Exception as error:
    print(error)
"""


@pytest.mark.parametrize("name", REAL)
def test_without_layers_it_gets_across(name: str) -> None:
    with world() as planted:
        scratch = planted.scratch(name)
        done = subprocess.run(
            [sys.executable, "-c", _UNPROTECTED.format(folder=str(Path(__file__).parent))],
            input=encode(planted.address(attempts()[name].source)),
            capture_output=True,
            cwd=scratch,
            timeout=30,
            check=False,
        )
        said = done.stdout.decode(errors="replace")
        assert planted.breaches(SandboxResult(Status.REWARD_FAILED, diagnosis=said), scratch)
