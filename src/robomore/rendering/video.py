"""Recorded episodes as a video file: rendered with OpenGL where it works, drawn elsewhere."""

from __future__ import annotations

import importlib
import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from errno import EACCES, ENOENT
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.errors import InputError
from robomore.plain_files import cannot_write, write_plain
from robomore.rendering.drawing import (
    elevation,
    ground_lines,
    nice_length,
    project,
    view_of,
)
from robomore.rendering.pictures import Frame, image
from robomore.rendering.recording import Recording
from robomore.tasks.portable import task_content

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
    remedy = "name a file elsewhere with --out"
    if not path.parent.is_dir():
        raise cannot_write(path, FileNotFoundError(ENOENT, "no such folder"), remedy)
    if not os.access(path.parent, os.W_OK):
        raise cannot_write(path, PermissionError(EACCES, "the folder cannot be written"), remedy)


def default_path(folder: Path, name: str) -> Path:
    """Return where a video of that name goes, in the best format that can be written."""
    return folder / f"{name}.{'mp4' if _has_ffmpeg() else 'webp'}"


def write_video(
    recordings: Sequence[Recording], path: Path, seconds: float, drawn: bool = False
) -> None:
    """Write episodes, or their first `seconds`, one below the other at one clock.

    An episode that ends before the others stays in its last pose.

    Args:
        recordings: at least one, all of one task.
        path: decides the format by its suffix.
        seconds: length at most.
        drawn: without OpenGL in any case; several episodes always are.

    Raises:
        InputError: the file cannot be written.
    """
    with TemporaryDirectory(prefix="robomore-") as scratch:
        # Whole or not at all, and never through a link that lies in the folder.
        made = Path(scratch) / f"video{path.suffix.lower()}"
        _write(recordings, made, seconds, drawn)
        try:
            write_plain(path, made.read_bytes())
        except OSError as error:
            raise cannot_write(path, error, "name a file elsewhere with --out") from None


def _write(recordings: Sequence[Recording], path: Path, seconds: float, drawn: bool) -> None:
    dt = recordings[0].dt
    stride = max(1, round(1 / (_FRAMES_PER_SECOND * dt)))
    length = min(max(len(one.poses) for one in recordings), int(seconds / dt) + 1)
    shown = [_held(one.poses, length)[::stride] for one in recordings]
    rate = 1 / (dt * stride)
    with TemporaryDirectory(prefix="robomore-") as scratch:
        rendered = None
        if len(recordings) == 1 and not drawn:
            rendered = _rendered(recordings[0], shown[0], Path(scratch))
        if rendered is not None:
            from PIL.Image import fromarray

            _encode((fromarray(np.asarray(frame)) for frame in rendered), path, rate, HEIGHT)
            return
    # Side by side at one scale, so that a small robot is seen to be small.
    width = max(_width(one) for one in recordings)
    columns = [
        draw_frames(one, poses, stride, width) for one, poses in zip(recordings, shown, strict=True)
    ]
    frames = (_stacked(pictures) for pictures in zip(*columns, strict=True))
    _encode(frames, path, rate, HEIGHT * len(recordings))


def _held(poses: NDArray[np.float64], length: int) -> NDArray[np.float64]:
    """Return so many poses; after the last one the robot stays where it is."""
    return poses[np.minimum(np.arange(length), len(poses) - 1)]


def _stacked(pictures: Sequence[Image]) -> Image:
    if len(pictures) == 1:
        return pictures[0]
    from PIL import Image as Images

    whole = Images.new("RGB", (WIDTH, HEIGHT * len(pictures)))
    for row, picture in enumerate(pictures):
        whole.paste(picture, (0, row * HEIGHT))
    return whole


def _width(recording: Recording) -> float:
    """Return how many metres wide the picture of a robot is."""
    data = mujoco.MjData(recording.model)
    data.qpos[:] = recording.poses[0]
    mujoco.mj_kinematics(recording.model, data)
    mujoco.mj_comPos(recording.model, data)
    bare = project(recording.model, data, view_of(recording.model))
    return _SIZES_WIDE * float(max(bare.high - bare.low))


def draw_frames(
    recording: Recording, poses: NDArray[np.float64], stride: int = 1, metres: float = 0.0
) -> Iterator[Image]:
    """Yield drawn pictures of the poses; the ground moves past the robot.

    Args:
        recording: the episode that they are of.
        poses: (frames, nq) joint positions.
        stride: control steps between two of them.
        metres: width of the picture; by default it fits the robot.
    """
    model, task = recording.model, recording.task
    data = mujoco.MjData(model)
    view = view_of(model)
    ground = elevation(task.terrain) if task.terrain and task.terrain.height else None
    metres = metres or _width(recording)
    for index, pose in enumerate(poses):
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        middle = data.subtree_com[1].copy()
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
        caption = f"{recording.title}   {seconds:5.1f} s   x = {middle[0]:.1f} m"
        yield image(scene, Frame(centre, metres, WIDTH, HEIGHT), caption)


def _rendered(
    recording: Recording, poses: NDArray[np.float64], scratch: Path
) -> NDArray[np.uint8] | None:
    """Return frames (poses, height, width, 3) from MuJoCo's renderer, or `None` without OpenGL.

    It runs in a process of its own: a broken driver ends a process, and cannot be asked before.
    """
    request, answer = scratch / "poses.npz", scratch / "frames.raw"
    task = np.frombuffer(task_content(recording.task), np.uint8)
    np.savez(request, poses=poses, parameters=np.array(recording.parameters), task=task)
    given = os.environ.get("MUJOCO_GL")
    platforms = ("egl", "osmesa") if sys.platform.startswith("linux") else ("",)
    for platform in (given,) if given else platforms:
        command = [sys.executable, "-m", "robomore.rendering.offscreen", recording.task.id]
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


def _encode(frames: Iterable[Image], path: Path, rate: float, height: int) -> None:
    if path.suffix.lower() == ".mp4":
        _encode_mp4(frames, path, rate, height)
        return
    first, *others = frames
    options: dict[str, Any] = {"save_all": True, "append_images": others, "loop": 0}
    if path.suffix.lower() == ".webp":
        options |= {"quality": 70, "method": 2}
    first.save(path, duration=round(1000 / rate), **options)


def _encode_mp4(frames: Iterable[Image], path: Path, rate: float, height: int) -> None:
    imageio_ffmpeg = importlib.import_module("imageio_ffmpeg")
    writer = imageio_ffmpeg.write_frames(str(path), (WIDTH, height), fps=rate, macro_block_size=8)
    writer.send(None)
    for frame in frames:
        writer.send(frame.tobytes())
    writer.close()


def _has_ffmpeg() -> bool:
    return importlib.util.find_spec("imageio_ffmpeg") is not None
