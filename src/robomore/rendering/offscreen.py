"""A process of its own that renders poses with OpenGL: `python -m robomore.rendering.offscreen`."""

from __future__ import annotations

import sys
from pathlib import Path

import mujoco
import numpy as np

from robomore.envs.compile import compile_model
from robomore.rendering.drawing import draw, view_of
from robomore.rendering.video import HEIGHT, WIDTH
from robomore.tasks.registry import carried_task

_SIZES_AWAY = 2.6


def render(task_id: str, request: Path, answer: Path) -> None:
    """Write raw RGB frames of the poses in `request` to `answer`."""
    with np.load(request, allow_pickle=False) as arrays:
        poses, parameters = arrays["poses"], arrays["parameters"].tolist()
        task = carried_task(task_id, arrays["task"].tobytes())
    model = compile_model(task, parameters)
    model.vis.global_.offwidth = max(WIDTH, model.vis.global_.offwidth)
    model.vis.global_.offheight = max(HEIGHT, model.vis.global_.offheight)
    data = mujoco.MjData(model)
    scene = draw(task, parameters)
    size = float(max(scene.high - scene.low))
    # Near and far are multiples of the extent, which a terrain would make a hundred times larger.
    model.stat.extent = 2 * size
    towards = view_of(model).towards
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_TRACKING
    camera.trackbodyid = 1
    camera.distance = _SIZES_AWAY * size
    camera.azimuth = float(np.degrees(np.arctan2(-towards[1], -towards[0])))
    camera.elevation = -max(10.0, float(np.degrees(np.arcsin(towards[2]))))
    with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer, answer.open("wb") as out:
        for pose in poses:
            data.qpos[:] = pose
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, camera)
            out.write(renderer.render().tobytes())


if __name__ == "__main__":
    render(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]))
