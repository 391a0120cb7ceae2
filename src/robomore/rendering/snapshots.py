"""A measured design in two pictures for a model that can see: its body, and how it moved."""

from __future__ import annotations

import io
import logging
from pathlib import Path
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from robomore.envs.vector_env import VectorEnv
from robomore.rendering.drawing import draw, ground_lines, nice_length, project, view_of
from robomore.rendering.pictures import Frame, frame_around, image
from robomore.tasks.task import Task
from robomore.training.policy import POLICY, MLPPolicy
from robomore.types import Evaluation

if TYPE_CHECKING:
    from PIL.Image import Image

log = logging.getLogger(__name__)

WIDTH, HEIGHT = 480, 360
"""Of the body's picture, in pixels."""
_FRAMES = 6
_STRIP_WIDTH, _STRIP_HEIGHT = 256, 192
_SECONDS_BETWEEN = 0.25


def pictures(task: Task, evaluation: Evaluation, artifacts: Path) -> list[bytes]:
    """Return PNG files: the body at rest, and a strip of frames from the start of an episode.

    Args:
        task: of the evaluation.
        evaluation: what is to be shown.
        artifacts: folder with the policies of the run; without this one's there is no strip.
    """
    parameters = evaluation.design.morphology.parameters
    scene = draw(task, parameters)
    found = [image(scene, frame_around(scene, WIDTH, HEIGHT))]
    policy = artifacts / evaluation.artifact / POLICY
    if evaluation.artifact and policy.is_file():
        try:
            found.append(_strip(task, parameters, MLPPolicy.load(policy), evaluation.job.seed))
        except ValueError as error:
            log.warning("no picture of how it moves: %s", error)
    return [_png(picture) for picture in found]


def _strip(task: Task, parameters: tuple[float, ...], policy: MLPPolicy, seed: int) -> Image:
    from PIL import Image as Images

    simulations = VectorEnv(task, parameters, 1, auto_reset=False)
    model, view = simulations.model, view_of(simulations.model)
    stride = max(1, round(_SECONDS_BETWEEN / float(simulations.environment.dt)))
    observation = simulations.reset_one(0, seed)[None]
    strip = Images.new("RGB", (_FRAMES * _STRIP_WIDTH, _STRIP_HEIGHT))
    data = mujoco.MjData(model)
    metres = 0.0
    for index in range(_FRAMES):
        data.qpos[:] = simulations.qpos[0]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        middle = data.subtree_com[1].copy()
        bare = project(model, data, view)
        # All frames at one scale; the eye follows the robot.
        metres = metres or 1.6 * float(max(bare.high - bare.low))
        ground = ground_lines(view, middle, 0.75 * metres, nice_length(metres / 4))
        frame = Frame(np.asarray(view.flat(middle)), metres, _STRIP_WIDTH, _STRIP_HEIGHT)
        caption = f"{index * stride * float(simulations.environment.dt):.2f} s"
        drawn = image(project(model, data, view, ground), frame, caption)
        strip.paste(drawn, (index * _STRIP_WIDTH, 0))
        for _ in range(stride):
            observation = simulations.step(policy.act(observation)).final_observation
    return strip


def _png(picture: Image) -> bytes:
    file = io.BytesIO()
    picture.save(file, "PNG")
    return file.getvalue()
