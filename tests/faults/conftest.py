"""An undisturbed run, which every disturbed one has to end like."""

from __future__ import annotations

from pathlib import Path

import pytest
from quick_run import SMOKE, ended


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("undisturbed") / "run"
    done = ended(*SMOKE, "--workers", "2", "--out", out)
    assert done.returncode == 0, done.stderr
    return out
