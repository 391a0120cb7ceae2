"""Dry runs that are remembered: a reward that was tried in this process before gives the same.

A dry run takes most of a second, and runs with a language model try the same few rewards again and
again. Import the fixture into a module of tests to which they do not matter.
"""

from __future__ import annotations

import pytest

from robomore.rewards.dry_run import DryRun, DryRunResult
from robomore.tasks.fingerprint import task_key

_KNOWN: dict[tuple[str, str, str], DryRunResult] = {}


@pytest.fixture(autouse=True)
def remembered_dry_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Try each reward once on each task."""
    real = DryRun.result

    def result(self: DryRun, source: str) -> DryRunResult:
        key = (task_key(self.task), source, self.containment)
        if key not in _KNOWN:
            _KNOWN[key] = real(self, source)
        return _KNOWN[key]

    monkeypatch.setattr(DryRun, "result", result)
