"""What a model that can see is shown: the morphology, and frames of how it moves."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from robomore.rendering.snapshots import pictures
from robomore.tasks import get_task


@pytest.mark.parametrize("name", ["swimmer", "ant"])
def test_a_robot_at_rest_and_a_strip_of_frames(name: str) -> None:
    task = get_task(name)
    motors = {"swimmer": 2, "ant": 8}[name]

    def act(observation: np.ndarray) -> np.ndarray:
        return np.full((len(observation), motors), 0.5)

    (alone,) = pictures(task, task.reference)
    still_png, strip_png = pictures(task, task.reference, act, seed=3)
    assert still_png == alone
    assert pictures(task, task.reference, act, seed=3)[1] == strip_png
    still, strip = (
        np.asarray(Image.open(io.BytesIO(png)).convert("L")) for png in (still_png, strip_png)
    )
    assert still.shape == (360, 480) and still.std() > 5
    frames = np.split(strip, 6, axis=1)
    assert all(frame.std() > 3 for frame in frames)
    # It moves, and not only the time that stands on each frame; an Ant soon comes to rest.
    assert len({frame[32:].tobytes() for frame in frames}) > 3
