"""A process of its own that renders poses with OpenGL: `python -m robomore.rendering.offscreen`.

It writes raw RGB frames to its standard output, one after the other, so that the process that asked
can show how far it is, and a broken driver ends no other process.
"""

from __future__ import annotations

import sys
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray
from PIL.Image import fromarray

from robomore.envs.compile import compile_model
from robomore.rendering.drawing import elevation, view_of
from robomore.rendering.video import HEIGHT, WIDTH
from robomore.tasks.registry import carried_task
from robomore.tasks.task import Task

_FINER = 2
"""Frames are rendered so many times larger and scaled down, which smooths every edge."""
_SHADOW = 2048
"""Pixels of the map of shadows."""
_LOWEST = 8.0
"""Least elevation of the eye, in degrees: the ground is seen, and with it the motion."""


def render(task_id: str, request: Path) -> None:
    """Write frames of the episodes in `request`, one below the other, to standard output.

    The request holds `metres`, the width of the picture, and for each episode `parametersI` and
    `posesI`; all have the same number of poses.
    """
    with np.load(request, allow_pickle=False) as arrays:
        asked = dict(arrays)
    task = carried_task(task_id, asked["task"].tobytes())
    count = sum(name.startswith("poses") for name in asked)
    stages = [
        _Stage(task, asked[f"parameters{i}"].tolist(), float(asked["metres"])) for i in range(count)
    ]
    with sys.stdout.buffer as out:
        for index in range(len(asked["poses0"])):
            for i, stage in enumerate(stages):
                out.write(stage.frame(asked[f"poses{i}"][index]))


class _Stage:
    """One robot, its ground and a camera that goes along with it."""

    def __init__(self, task: Task, parameters: list[float], metres: float) -> None:
        model = self.model = compile_model(task, parameters)
        model.vis.global_.offwidth = _FINER * WIDTH
        model.vis.global_.offheight = _FINER * HEIGHT
        # Without a graphics card, these take most of the time.
        model.vis.quality.shadowsize = _SHADOW
        model.vis.quality.offsamples = 0
        # Near and far are multiples of the extent, which a terrain makes a hundred times larger.
        model.stat.extent = metres
        # A plane without edges is drawn wherever the camera is.
        planes = (model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE) & (model.geom_bodyid == 0)
        model.geom_size[planes, :2] = 0
        self.data = mujoco.MjData(model)
        self.ground = elevation(task.terrain) if task.terrain and task.terrain.height else None
        self.metres = metres
        towards = view_of(model).towards
        camera = self.camera = mujoco.MjvCamera()
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        half = np.radians(model.vis.global_.fovy / 2)
        camera.distance = metres * HEIGHT / WIDTH / 2 / np.tan(half)
        camera.azimuth = float(np.degrees(np.arctan2(-towards[1], -towards[0])))
        camera.elevation = -max(_LOWEST, float(np.degrees(np.arcsin(towards[2]))))
        self.renderer = mujoco.Renderer(model, _FINER * HEIGHT, _FINER * WIDTH)

    def frame(self, pose: NDArray[np.float64]) -> bytes:
        """Return a picture: height x width x 3 bytes."""
        model, data = self.model, self.data
        data.qpos[:] = pose
        mujoco.mj_forward(model, data)
        x, y, z = data.subtree_com[1].tolist()
        level = float(self.ground(np.array([x]), np.array([y]))[0]) if self.ground else 0.0
        # The eye follows along the ground, and upwards only where the robot would be out of sight.
        height = self.metres * HEIGHT / WIDTH
        self.camera.lookat[:] = x, y, max(level + 0.25 * height, z - 0.25 * height)
        # Lights go along too, or the shadow would end some metres from the start.
        data.light_xpos[:, :2] += x, y
        self.renderer.update_scene(data, self.camera)
        return fromarray(self.renderer.render()).reduce(_FINER).tobytes()


if __name__ == "__main__":
    render(sys.argv[1], Path(sys.argv[2]))
