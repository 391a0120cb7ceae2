"""A recorded episode as a video file: rendered with OpenGL where it works, drawn elsewhere."""

from __future__ import annotations

import importlib
import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.errors import InputError
from robomore.rendering.drawing import (
    elevation,
    ground_lines,
    nice_length,
    project,
    view_of,
)
from robomore.rendering.pictures import Frame, image
from robomore.rendering.recording import Recording

if TYPE_CHECKING:
    from PIL.Image import Image

WIDTH, HEIGHT = 640, 360
_FRAMES_PER_SECOND = 30
_SIZES_WIDE = 3.2
"""The picture is so many robots wide."""
_ANIMATED = (".webp", ".gif")
_RENDER_SECONDS = 600.0


def refuse_format(path: Path) -> None:
    """Refuse a video that could not be written, before anything is done.

    Raises:
        InputError: an unknown suffix, a missing encoder or a missing folder.
    """
    suffix = path.suffix.lower()
    if suffix == ".mp4":
        if not _has_ffmpeg():
            raise InputError(
                f"{path} needs imageio-ffmpeg (pip install imageio-ffmpeg); or end it in .webp"
            )
    elif suffix not in _ANIMATED:
        raise InputError(f"{path} is no video that can be written; end it in .mp4, .webp or .gif")
    if not path.parent.is_dir() or not os.access(path.parent, os.W_OK):
        raise InputError(f"cannot write to {path.parent}; name a file elsewhere with --out")


def default_path(name: str) -> Path:
    """Return where a video goes when nobody says: here, in the best format that can be written."""
    return Path(f"{name}.{'mp4' if _has_ffmpeg() else 'webp'}")


def write_video(recording: Recording, path: Path, seconds: float, drawn: bool = False) -> None:
    """Write an episode, or its first `seconds`.

    Args:
        recording: the episode.
        path: decides the format by its suffix.
        seconds: length at most.
        drawn: without OpenGL in any case.
    """
    stride = max(1, round(1 / (_FRAMES_PER_SECOND * recording.dt)))
    poses = recording.poses[: int(seconds / recording.dt) + 1 : stride]
    rate = 1 / (recording.dt * stride)
    with TemporaryDirectory(prefix="robomore-") as scratch:
        rendered = None if drawn else _rendered(recording, poses, Path(scratch))
        if rendered is None:
            _encode(draw_frames(recording, poses, stride), path, rate)
        else:
            from PIL.Image import fromarray

            _encode((fromarray(np.asarray(frame)) for frame in rendered), path, rate)


def draw_frames(
    recording: Recording, poses: NDArray[np.float64], stride: int = 1
) -> Iterator[Image]:
    """Yield drawn pictures of the poses; the ground moves past the robot."""
    model, task = recording.model, recording.performer.task
    data = mujoco.MjData(model)
    view = view_of(model)
    ground = elevation(task.terrain) if task.terrain and task.terrain.height else None
    metres = 0.0
    for index, pose in enumerate(poses):
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        middle = data.subtree_com[1].copy()
        bare = project(model, data, view)
        if not metres:
            metres = _SIZES_WIDE * float(max(bare.high - bare.low))
        spacing = nice_length(metres / 4)
        # The eye follows along the ground, so that hops and falls are seen as such.
        from_above = view.towards[2] > 0.9
        centre = view.flat(middle if from_above else middle * (1, 1, 0))
        centre[1] += 0.0 if from_above else 0.16 * metres
        if ground is not None:
            centre[1] += view.up[2] * float(ground(middle[:1], middle[1:2])[0])
        scene = project(
            model, data, view, ground_lines(view, middle, 0.75 * metres, spacing, ground)
        )
        seconds = index * stride * recording.dt
        caption = f"{recording.performer.title}   {seconds:5.1f} s   x = {middle[0]:.1f} m"
        yield image(scene, Frame(centre, metres, WIDTH, HEIGHT), caption)


def _rendered(
    recording: Recording, poses: NDArray[np.float64], scratch: Path
) -> NDArray[np.uint8] | None:
    """Return frames (poses, height, width, 3) from MuJoCo's renderer, or `None` without OpenGL.

    It runs in a process of its own: a broken driver ends a process, and cannot be asked before.
    """
    request, answer = scratch / "poses.npz", scratch / "frames.raw"
    performer = recording.performer
    np.savez(request, poses=poses, parameters=np.array(performer.parameters))
    given = os.environ.get("MUJOCO_GL")
    platforms = ("egl", "osmesa") if sys.platform.startswith("linux") else ("",)
    for platform in (given,) if given else platforms:
        command = [sys.executable, "-m", "robomore.rendering.offscreen", performer.task.id]
        environment = os.environ | ({"MUJOCO_GL": platform} if platform else {})
        try:
            done = subprocess.run(
                [*command, str(request), str(answer)],
                env=environment,
                capture_output=True,
                timeout=_RENDER_SECONDS,
                check=False,
            )
        except subprocess.TimeoutExpired:
            continue
        shape = (len(poses), HEIGHT, WIDTH, 3)
        if done.returncode == 0 and answer.stat().st_size == int(np.prod(shape)):
            return np.memmap(answer, np.uint8, "r", shape=shape)
    return None


def _encode(frames: Iterable[Image], path: Path, rate: float) -> None:
    if path.suffix.lower() == ".mp4":
        _encode_mp4(frames, path, rate)
        return
    first, *others = frames
    options: dict[str, Any] = {"save_all": True, "append_images": others, "loop": 0}
    if path.suffix.lower() == ".webp":
        options |= {"quality": 70, "method": 2}
    first.save(path, duration=round(1000 / rate), **options)


def _encode_mp4(frames: Iterable[Image], path: Path, rate: float) -> None:
    imageio_ffmpeg = importlib.import_module("imageio_ffmpeg")
    writer = imageio_ffmpeg.write_frames(str(path), (WIDTH, HEIGHT), fps=rate, macro_block_size=8)
    writer.send(None)
    for frame in frames:
        writer.send(frame.tobytes())
    writer.close()


def _has_ffmpeg() -> bool:
    return importlib.util.find_spec("imageio_ffmpeg") is not None
