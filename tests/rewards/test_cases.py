"""Rewards as models and users write them: each is right, or refused in its line and in words."""

from __future__ import annotations

from pathlib import Path

import pytest

from robomore.errors import InvalidReward, RewardFailed
from robomore.rewards.check import check_reward
from robomore.rewards.continuation import check_continuation
from robomore.rewards.load import load_reward
from robomore.tasks import get_task

FOLDER = Path(__file__).parent / "cases"
CASES = {path.stem.removeprefix("reward-"): path for path in sorted(FOLDER.glob("reward-*.py"))}
REFUSED = {"spec-is-none": (2, "`self.spec` is None")}
NOTED = {
    "counter-over-training": (3, "`self.training_steps` counts over the whole training"),
    "helper-class-state": (14, "keeps `self._speed` between the steps of an episode"),
}


def test_there_are_cases() -> None:
    assert len(CASES) >= 8


@pytest.mark.parametrize("name", CASES)
def test_a_case_is_right_or_refused(name: str) -> None:
    """Those that are right are known to continue from a checkpoint with the same numbers."""
    source, task = CASES[name].read_text(encoding="utf-8"), get_task("ant")
    found = [(it.line, it.severity, it.message) for it in check_reward(source)]
    if name in REFUSED:
        line, said = REFUSED[name]
        assert any(it[:2] == (line, "error") and said in it[2] for it in found)
        with pytest.raises((InvalidReward, RewardFailed)):
            check_continuation(task, task.reference, load_reward(source))
        return
    assert [it for it in found if it[1] != "note"] == []
    if name in NOTED:
        line, said = NOTED[name]
        assert any(it[:2] == (line, "note") and said in it[2] for it in found)
    check_continuation(task, task.reference, load_reward(source))
