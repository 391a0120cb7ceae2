"""Whether a picture can be rendered here, found out in a process of its own.

A broken driver ends a process, or fails long after it was asked; so it is tried elsewhere first.
"""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache

from robomore.errors import InputError

PLATFORM = "MUJOCO_GL"
"""Environment variable by which MuJoCo and Gymnasium choose among OpenGL's platforms."""

_TRY = (
    "import mujoco; context = mujoco.GLContext(64, 64); context.make_current(); "
    "mujoco.MjrContext(mujoco.MjModel.from_xml_string('<mujoco/>'), 150)"
)
_SECONDS = 60.0


@cache
def ensure_opengl() -> None:
    """Make sure that pictures can be rendered without a window, with or without a screen.

    Without a screen it chooses a platform that needs none, for this process and those it starts.

    Raises:
        InputError: there is none that works.
    """
    given = os.environ.get(PLATFORM)
    if not given and (sys.platform != "linux" or _has_screen()):
        return
    for platform in (given,) if given else ("egl", "osmesa"):
        if _works(platform):
            os.environ[PLATFORM] = platform
            return
    if given:
        tried = f"{PLATFORM}={given} does not work; set it to egl or osmesa"
    else:
        tried = "there is no screen, and neither EGL nor OSMesa works"
    raise InputError(
        f"no picture can be rendered here: {tried}; install libegl1 or libosmesa6 (their names on "
        "Debian and Ubuntu), or draw without OpenGL: robomore play RUN --drawn"
    )


def _has_screen() -> bool:
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _works(platform: str) -> bool:
    command = [sys.executable, "-c", _TRY]
    environment = os.environ | {PLATFORM: platform}
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, timeout=_SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0
