"""What training is given to train in."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import pytest

from robomore.envs.vector_env import VectorEnv
from robomore.evaluation import train as module
from robomore.evaluation.request import Request
from robomore.tasks import get_task
from robomore.text import to_json
from robomore.training.trainer import TrainingResult
from robomore.types import Design, Job, Morphology, Reward, TrainerSettings


class Looks:
    """A trainer that looks at the simulations and trains nothing."""

    seen: VectorEnv

    def train(self, environment: VectorEnv, *given: Any, **more: Any) -> TrainingResult:
        self.seen = environment
        return TrainingResult(())


@pytest.mark.parametrize(
    ("trainer", "rk4"),
    [
        (TrainerSettings("crossq"), False),
        (TrainerSettings("crossq", {"replace_rk4": False}), True),
        (TrainerSettings("sac"), True),
    ],
)
def test_the_trainer_says_whether_rk4_is_replaced(
    trainer: TrainerSettings, rk4: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    task, looks = get_task("hopper"), Looks()
    monkeypatch.setattr(module, "make_trainer", lambda settings: looks)
    design = Design(Morphology(task.reference), Reward(task.reward))
    job = Job("hopper", design, trainer, steps=100, episodes=1, seed=0)
    module.train(to_json(Request(job, "key", str(tmp_path))), tmp_path, lambda steps: None)
    assert (looks.seen.model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4) is rk4
