"""The smallest run that still trains, and what has to be the same in two runs of one seed."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

from robomore.settings import Budget, FinalSettings, RunSettings
from robomore.store import Ledger, RunFolder
from robomore.types import MethodSettings, Status, TrainerSettings

TINY = RunSettings(
    method=MethodSettings(
        "robomore",
        {
            "morphologies": 2,
            "rewards": 1,
            "reference_reward": "out",
            "survivors": 0.5,
            "max_cycles": 1,
        },
    ),
    # Small and eager: it need not get far, only somewhere.
    trainer=TrainerSettings(
        "crossq",
        {
            "net_arch": [32],
            "batch_size": 32,
            "learning_starts": 256,
            "num_eval_checkpoints": 1,
        },
    ),
    candidate=Budget(steps=768, episodes=2),
    final=FinalSettings(steps=512, episodes=1, seeds=1),
    evaluations=2,
)


def numbers(folder: Path) -> list[tuple[str, str, Status, float | None, float | None]]:
    """Return everything that has to be the same in two runs of one seed."""
    with closing(Ledger(RunFolder.existing(folder).ledger, read_only=True)) as ledger:
        placed = ledger.placed()
    return sorted((repr(p), e.key, e.status, e.fitness, e.efficiency) for p, e in placed)
