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


INSTALL = "apt install libosmesa6 (its name on Debian and Ubuntu), which needs no graphics card"
"""What to do where no platform works."""


@cache
def ensure_opengl() -> None:
    """Make sure that pictures can be rendered without a window, with or without a screen.

    Without a screen it chooses a platform that needs none, for this process and those it starts.

    Raises:
        InputError: there is none that works.
    """
    if not os.environ.get(PLATFORM) and (sys.platform != "linux" or _has_screen()):
        return
    platform = offscreen_platform()
    if platform is None:
        raise InputError(
            f"no picture can be rendered here: {why_none()}, or draw without OpenGL: "
            "robomore play RUN --drawn"
        )
    os.environ[PLATFORM] = platform


def ensure_screen() -> None:
    """Make sure that a window can be shown. Without a screen, GLFW would end the process.

    Raises:
        InputError: this is Linux, and no screen is named in the environment.
    """
    if sys.platform == "linux" and not _has_screen():
        raise InputError(
            'render_mode="human" needs a screen, and neither DISPLAY nor WAYLAND_DISPLAY is set; '
            'use render_mode="rgb_array", which returns pictures'
        )


def offscreen_platform() -> str | None:
    """Return the platform that renders without a screen, the one that was asked for if any.

    Returns:
        An empty text for the system's own, `None` if none works.
    """
    given = os.environ.get(PLATFORM)
    usual = ("egl", "osmesa") if sys.platform == "linux" else ("",)
    return next((one for one in ((given,) if given else usual) if _works(one)), None)


def why_none() -> str:
    """Return why no platform works, and what to do about it."""
    given = os.environ.get(PLATFORM)
    if given:
        return f"{PLATFORM}={given} does not work; set it to egl or osmesa, or {INSTALL}"
    return f"neither EGL nor OSMesa works; {INSTALL}"


def _has_screen() -> bool:
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


@cache
def _works(platform: str) -> bool:
    command = [sys.executable, "-c", _TRY]
    environment = os.environ | ({PLATFORM: platform} if platform else {})
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, timeout=_SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0
