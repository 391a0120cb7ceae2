"""A robot in two pictures for a model that can see: at rest, and how it moves."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from robomore.envs.vector_env import VectorEnv
from robomore.rendering.drawing import draw, ground_lines, nice_length, project, view_of
from robomore.rendering.pictures import Frame, frame_around, image
from robomore.rendering.recording import Act
from robomore.tasks.task import Task

if TYPE_CHECKING:
    from PIL.Image import Image

WIDTH, HEIGHT = 480, 360
"""Of the picture at rest, in pixels."""
_FRAMES = 6
_STRIP_WIDTH, _STRIP_HEIGHT = 256, 192
_SECONDS_BETWEEN = 0.25


def pictures(
    task: Task, parameters: tuple[float, ...], act: Act | None = None, seed: int = 0
) -> list[bytes]:
    """Return PNG files: the robot at rest, and a strip of frames from the start of an episode.

    Args:
        task: what the robot is for.
        parameters: of its morphology.
        act: the policy; without one there is no strip.
        seed: of the episode.
    """
    scene = draw(task, parameters)
    found = [image(scene, frame_around(scene, WIDTH, HEIGHT))]
    if act is not None:
        found.append(_strip(task, parameters, act, seed))
    return [_png(picture) for picture in found]


def _strip(task: Task, parameters: tuple[float, ...], act: Act, seed: int) -> Image:
    from PIL import Image as Images

    env = VectorEnv(task, parameters, 1, auto_reset=False)
    model, view = env.model, view_of(env.model)
    stride = max(1, round(_SECONDS_BETWEEN / float(env.environment.dt)))
    observation = env.reset_one(0, seed)[None]
    strip = Images.new("RGB", (_FRAMES * _STRIP_WIDTH, _STRIP_HEIGHT))
    data = mujoco.MjData(model)
    metres = 0.0
    for index in range(_FRAMES):
        data.qpos[:] = env.qpos[0]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        middle = data.subtree_com[1].copy()
        bare = project(model, data, view)
        # All frames at one scale; the eye follows the robot.
        metres = metres or 1.6 * float(max(bare.high - bare.low))
        ground = ground_lines(view, middle, 0.75 * metres, nice_length(metres / 4))
        frame = Frame(np.asarray(view.flat(middle)), metres, _STRIP_WIDTH, _STRIP_HEIGHT)
        caption = f"{index * stride * float(env.environment.dt):.2f} s"
        drawn = image(project(model, data, view, ground), frame, caption)
        strip.paste(drawn, (index * _STRIP_WIDTH, 0))
        for _ in range(stride):
            observation = env.step(act(observation)).final_observation
    return strip


def _png(picture: Image) -> bytes:
    file = io.BytesIO()
    picture.save(file, "PNG")
    return file.getvalue()
