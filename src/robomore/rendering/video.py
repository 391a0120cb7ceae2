"""Recorded episodes as a video file: rendered with OpenGL where it works, drawn elsewhere."""

from __future__ import annotations

import importlib
import importlib.util
import itertools
import os
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from errno import EACCES, ENOENT
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.opengl import PLATFORM, offscreen_platform, why_none
from robomore.errors import InputError, VideoFailed
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
from robomore.text import shortened

if TYPE_CHECKING:
    from PIL.Image import Image

WIDTH, HEIGHT = 640, 360
_FRAMES_PER_SECOND = 30
_SIZES_WIDE = 2.2
"""The picture is so many robots wide."""
_THIN = 1.5
"""Pixels: a robot with thinner parts is drawn, since a drawing keeps them visible."""
_ANIMATED = (".webp", ".gif")

Progress = Callable[[int, int], None]
"""Told how many frames of how many there are."""


def refuse_format(path: Path) -> None:
    """Refuse a video that could not be written, before anything is done.

    Raises:
        InputError: an unknown suffix, a missing encoder or a missing folder.
    """
    suffix = path.suffix.lower()
    if suffix == ".mp4":
        if not _has_ffmpeg():
            raise InputError(
                f"{path} needs an encoder for MP4, which is not installed: pip install "
                '"robomore[video]"; or end it in .webp'
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
    recordings: Sequence[Recording],
    path: Path,
    seconds: float,
    drawn: bool = False,
    progress: Progress = lambda done, all: None,
) -> str:
    """Write episodes, or their first `seconds`, one below the other at one clock and one scale.

    An episode that ends before the others stays in its last pose.

    Args:
        recordings: at least one, all of one task.
        path: decides the format by its suffix.
        seconds: length at most.
        drawn: without OpenGL in any case.
        progress: is told how many frames there are, and how many there will be.

    Returns:
        Why the video was drawn and not rendered with OpenGL; empty if it was rendered.

    Raises:
        InputError: the file cannot be written.
        VideoFailed: OpenGL failed on the way.
    """
    with TemporaryDirectory(prefix="robomore-") as scratch:
        # Whole or not at all, and never through a link that lies in the folder.
        made = Path(scratch) / f"video{path.suffix.lower()}"
        why = _write(recordings, made, seconds, drawn, progress)
        try:
            write_plain(path, made.read_bytes())
        except OSError as error:
            raise cannot_write(path, error, "name a file elsewhere with --out") from None
    return why


def _write(
    recordings: Sequence[Recording], path: Path, seconds: float, drawn: bool, progress: Progress
) -> str:
    dt = recordings[0].dt
    stride = max(1, round(1 / (_FRAMES_PER_SECOND * dt)))
    length = min(max(len(one.poses) for one in recordings), int(seconds / dt) + 1)
    shown = [_held(one.poses, length)[::stride] for one in recordings]
    # At one scale, so that a small robot is seen to be small.
    metres = max(_width(one) for one in recordings)
    why = "" if not drawn else "so it was asked"
    if not why and _thinnest(recordings, metres) < _THIN:
        why = "the robot is so thin that rendered parts would flicker"
    if not why and offscreen_platform() is None:
        why = f"there is no OpenGL: {why_none()}"
    frames = (
        _drawn(recordings, shown, stride, metres)
        if why
        else _rendered(recordings, shown, stride, metres)
    )

    def counted() -> Iterator[Image]:
        for index, frame in enumerate(frames, 1):
            progress(index, len(shown[0]))
            yield frame

    _encode(counted(), path, 1 / (dt * stride), HEIGHT * len(recordings))
    return why


def _drawn(
    recordings: Sequence[Recording],
    shown: Sequence[NDArray[np.float64]],
    stride: int,
    metres: float,
) -> Iterator[Image]:
    columns = [
        draw_frames(one, poses, stride, metres)
        for one, poses in zip(recordings, shown, strict=True)
    ]
    return (_stacked(pictures) for pictures in zip(*columns, strict=True))


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
        caption = _caption(recording, index * stride)
        yield image(scene, Frame(centre, metres, WIDTH, HEIGHT), caption)


def _rendered(
    recordings: Sequence[Recording],
    shown: Sequence[NDArray[np.float64]],
    stride: int,
    metres: float,
) -> Iterator[Image]:
    """Yield pictures from MuJoCo's renderer, which runs in a process of its own.

    Raises:
        VideoFailed: it ended too early.
    """
    from PIL.Image import frombytes

    size = (WIDTH, HEIGHT * len(recordings))
    with TemporaryDirectory(prefix="robomore-") as scratch:
        request = Path(scratch) / "poses.npz"
        arrays = {f"poses{i}": poses for i, poses in enumerate(shown)}
        arrays |= {f"parameters{i}": np.array(one.parameters) for i, one in enumerate(recordings)}
        arrays["task"] = np.frombuffer(task_content(recordings[0].task), np.uint8)
        np.savez(request, metres=np.array(metres), **arrays)  # type: ignore[arg-type]
        platform = offscreen_platform()
        command = [sys.executable, "-m", "robomore.rendering.offscreen", recordings[0].task.id]
        process = subprocess.Popen(
            [*command, str(request)],
            env=os.environ | ({PLATFORM: platform} if platform else {}),
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        with process:
            assert process.stdout is not None
            try:
                for index in range(len(shown[0])):
                    raw = process.stdout.read(size[0] * size[1] * 3)
                    if len(raw) < size[0] * size[1] * 3:
                        raise VideoFailed(
                            f"OpenGL ({platform}) failed in frame {index + 1}; draw without it: "
                            "--drawn"
                        )
                    picture = frombytes("RGB", size, raw)
                    _label(picture, recordings, shown, index, stride)
                    yield picture
            finally:
                process.kill()


def _label(
    picture: Image,
    recordings: Sequence[Recording],
    shown: Sequence[NDArray[np.float64]],
    index: int,
    stride: int,
) -> None:
    """Write name, time and way of each robot into its part of the picture."""
    from PIL import ImageDraw, ImageFont

    pen, font = ImageDraw.Draw(picture), ImageFont.load_default(14.0)
    for row, one in enumerate(recordings):
        pen.text((12, row * HEIGHT + 10), _caption(one, index * stride), "#222222", font)


def _caption(recording: Recording, step: int) -> str:
    """Return name, time and way from the start, which fitness counts too, after so many steps.

    The last pose stays once the episode has ended.
    """
    roots = recording.roots
    x = float(roots[min(step, len(roots) - 1), 0] - roots[0, 0])
    return f"{shortened(recording.title)}   {step * recording.dt:5.1f} s   x = {x:.1f} m"


def _thinnest(recordings: Sequence[Recording], metres: float) -> float:
    """Return how many pixels wide the thinnest part of the robots is."""
    sizes = [
        2 * float(one.model.geom_size[one.model.geom_bodyid > 0, 0].min()) for one in recordings
    ]
    return min(sizes) * WIDTH / metres


def _encode(frames: Iterable[Image], path: Path, rate: float, height: int) -> None:
    if path.suffix.lower() == ".mp4":
        _encode_mp4(frames, path, rate, height)
        return
    first, *others = frames
    options: dict[str, Any] = {"save_all": True, "append_images": others, "loop": 0}
    if path.suffix.lower() == ".webp":
        options |= {"quality": 70, "method": 2}
    tick = 10 if path.suffix.lower() == ".gif" else 1  # ms: a GIF knows no less
    first.save(path, duration=durations(len(others) + 1, rate, tick), **options)


def durations(frames: int, rate: float, tick: int) -> list[int]:
    """Return how long each frame is shown, in ms, so that all together take their true time.

    Args:
        frames: how many there are.
        rate: frames in a second.
        tick: ms that each time is a multiple of.
    """
    ends = [tick * round(1000 * n / (rate * tick)) for n in range(frames + 1)]
    return [after - before for before, after in itertools.pairwise(ends)]


def _encode_mp4(frames: Iterable[Image], path: Path, rate: float, height: int) -> None:
    imageio_ffmpeg = importlib.import_module("imageio_ffmpeg")
    writer = imageio_ffmpeg.write_frames(str(path), (WIDTH, height), fps=rate, macro_block_size=8)
    writer.send(None)
    for frame in frames:
        writer.send(frame.tobytes())
    writer.close()


def _has_ffmpeg() -> bool:
    return importlib.util.find_spec("imageio_ffmpeg") is not None
