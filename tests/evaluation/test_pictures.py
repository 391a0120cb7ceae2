"""What a model that can see is shown: the body, and frames of how it moved."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from robomore.envs.vector_env import VectorEnv
from robomore.rendering.snapshots import pictures
from robomore.tasks import get_task
from robomore.training.policy import MLPPolicy
from robomore.types import Design, Evaluation, Job, Morphology, Reward, Status, TrainerSettings


@pytest.mark.parametrize("name", ["swimmer", "ant"])
def test_a_body_and_a_strip_of_frames(name: str, tmp_path: Path) -> None:
    task = get_task(name)
    robot = VectorEnv(task, task.reference, 1)
    shape = (robot.observation_size, robot.action_size)
    policy = MLPPolicy((np.zeros(shape, np.float32),), (np.full(shape[1], 0.5, np.float32),))
    (tmp_path / "key").mkdir()
    policy.save(tmp_path / "key" / "policy.npz")
    design = Design(Morphology(task.reference), Reward(task.reward))
    job = Job(task.id, design, TrainerSettings(), 1, 1, 0)
    measured = Evaluation("key", job, Status.OK, fitness=1.0, volume=1.0, efficiency=1.0)

    (alone,) = pictures(task, measured, tmp_path)
    body, strip = pictures(task, replace(measured, artifact="key"), tmp_path)
    assert body == alone
    assert pictures(task, replace(measured, artifact="key"), tmp_path)[1] == strip
    still, frames = (np.asarray(Image.open(io.BytesIO(png)).convert("L")) for png in (body, strip))
    assert still.shape == (360, 480) and still.std() > 5
    pictured = np.split(frames, 6, axis=1)
    assert all(frame.std() > 3 for frame in pictured)
    # It moves, and not only the time that stands on each frame; an Ant soon comes to rest.
    assert len({frame[32:].tobytes() for frame in pictured}) > 3
    assert [pictures(task, replace(measured, artifact="gone"), tmp_path)[0]] == [body]
