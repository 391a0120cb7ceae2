"""The five human designs pass their audit, really trained. Minutes each; see docs/audit.md."""

from __future__ import annotations

from pathlib import Path

import pytest

from robomore.audit import Subject, audit
from robomore.experiment import evaluate
from robomore.tasks import get_task
from robomore.training.policy import POLICY, MLPPolicy

STEPS = {
    "swimmer": 100_000,
    "half-cheetah": 100_000,
    "hopper": 300_000,
    "walker": 300_000,
    "ant": 300_000,
}
"""Of training, enough for each to run."""


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", STEPS)
def test_a_human_design_passes(name: str, tmp_path: Path) -> None:
    task = get_task(name)
    trained = evaluate(task, settings="standard", steps=STEPS[name], artifact=tmp_path)
    assert trained.ok, trained.diagnosis
    policy = MLPPolicy.load(tmp_path / POLICY)
    found = audit(Subject(task, task.reference, policy, trained.fitness))
    assert found.passes, [one.says for one in found.failed]
