"""One episode of a moving robot, as poses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageDraw

from robomore.rendering import video
from robomore.rendering.recording import record
from robomore.tasks import get_task


def still(observation: Any) -> Any:
    return np.zeros((len(observation), 3))


def test_an_episode_ends_when_the_robot_falls() -> None:
    task = get_task("hopper")
    seen = record(task, task.reference, still, "still", seed=1)
    again = record(task, task.reference, still, "still", seed=1)
    assert seen.fell and len(seen.poses) < task.episode_steps
    assert seen.poses.shape[1] == seen.model.nq
    assert np.array_equal(seen.poses, again.poses)
    assert not np.array_equal(seen.poses[0], record(task, task.reference, still, "", 2).poses[0])
    assert seen.seconds == (len(seen.poses) - 1) * seen.dt
    assert seen.distance == seen.poses[-1, 0] - seen.poses[0, 0]
    assert seen.height >= seen.poses[0, 1]
    start = seen.first(10 * seen.dt)
    assert len(start.poses) == 11 and start.seconds == 10 * seen.dt and not start.fell
    assert start.distance == seen.poses[10, 0] - seen.poses[0, 0]
    assert seen.first(1e3) is seen


def test_an_episode_ends_when_its_time_is_up() -> None:
    task = get_task("swimmer")
    seen = record(task, task.reference, lambda one: np.zeros((len(one), 2)), "still")
    assert not seen.fell and len(seen.poses) == task.episode_steps + 1


def test_drawn_and_rendered_videos_tell_the_way_from_the_start(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    task = get_task("swimmer")
    seen = record(task, task.reference, lambda one: np.ones((len(one), 2)), "moving").first(2.0)
    drawn: list[str] = []
    monkeypatch.setattr(video, "image", lambda scene, frame, caption: drawn.append(caption))
    stride = 5
    poses = seen.poses[::stride]
    # The last pose is held while another robot goes on.
    poses = np.concatenate([poses, poses[-1:]])
    list(video.draw_frames(seen, poses, stride))
    rendered: list[str] = []

    class Pen:
        def text(self, place: Any, said: str, *_: Any) -> None:
            rendered.append(said)

    monkeypatch.setattr(ImageDraw, "Draw", lambda picture: Pen())
    for index in range(len(poses)):
        video._label(Image.new("RGB", (8, 8)), [seen], [poses], index, stride)
    assert drawn == rendered
    assert drawn[0].endswith("x = 0.0 m")
    assert drawn[-2].endswith(f"x = {seen.distance:.1f} m")
    assert drawn[-1].endswith(f"x = {seen.distance:.1f} m")
