"""A recorded episode in MuJoCo's own viewer, over and over until its window is closed."""

from __future__ import annotations

import importlib
import logging
import time

import mujoco

from robomore.rendering.drawing import draw
from robomore.rendering.recording import Recording

_SIZES_AWAY = 2.6
_PAUSE = 1.0
"""Seconds between two repetitions."""


def show_in_window(recording: Recording) -> bool:
    """Play in real time; returns whether a window could be opened."""
    data = mujoco.MjData(recording.model)
    scene = draw(recording.task, recording.parameters)
    size = float(max(scene.high - scene.low))
    # Near and far are multiples of the extent, which a terrain would make a hundred times larger.
    recording.model.stat.extent = 2 * size
    try:
        # Loaded here: without a screen it may fail in its own way.
        viewer = importlib.import_module("mujoco.viewer")
        handle = viewer.launch_passive(
            recording.model, data, show_left_ui=False, show_right_ui=False
        )
    except Exception as error:  # noqa: BLE001  # every platform fails in its own way
        logging.getLogger(__name__).warning("MuJoCo's viewer: %s", error)
        return False
    with handle as window:
        window.cam.type = mujoco.mjtCamera.mjCAMERA_TRACKING
        window.cam.trackbodyid = 1
        window.cam.distance = _SIZES_AWAY * size
        while window.is_running():
            for pose in recording.poses:
                if not window.is_running():
                    break
                began = time.monotonic()
                data.qpos[:] = pose
                mujoco.mj_forward(recording.model, data)
                window.sync()
                time.sleep(max(0.0, recording.dt - (time.monotonic() - began)))
            time.sleep(_PAUSE)
    return True
