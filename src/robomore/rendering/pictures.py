"""Scenes as SVG text and as pixels (Pillow): the same picture for pages, files and videos."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from robomore.errors import InputError
from robomore.plain_files import cannot_write
from robomore.rendering.drawing import Array, Scene, Stroke, nice_length
from robomore.text import shortened

if TYPE_CHECKING:
    from PIL.Image import Image

_THINNEST = 1.6
"""In pixels: a thinner part is drawn this thick, or it would not be seen."""
_EDGE, _SHINE = 0.62, 1.28
"""Brightness of a part's outline and of the light on it."""
_MARGIN = 0.08
_SIGN, _ROW = 8.0, 22.0
"""Radius of a mark's disc and height of a row of the legend, in pixels."""


@dataclass(frozen=True, slots=True)
class Frame:
    """Which part of a scene goes where.

    Attributes:
        centre: (2,) of the picture, in m.
        metres: that the picture is wide.
        width: in pixels.
        height: in pixels.
    """

    centre: Array
    metres: float
    width: int
    height: int

    @property
    def scale(self) -> float:
        """Pixels to the metre."""
        return self.width / self.metres

    def pixels(self, points: Array) -> Array:
        """Return points (..., 2) in m as pixels to the right and down."""
        middle = np.array([self.width, self.height]) / 2
        return np.asarray(middle + (points - self.centre) * self.scale * (1, -1))


def frame_around(
    scene: Scene, width: int, height: int, alike: Sequence[Scene] = (), margin: float = _MARGIN
) -> Frame:
    """Return the frame that shows a whole scene.

    Args:
        scene: what to show.
        width: in pixels.
        height: in pixels.
        alike: scenes that are to be shown at the same scale, in frames of the same size.
        margin: left free on each side, as a share of the picture.
    """
    extents = np.max([one.high - one.low for one in (scene, *alike)], axis=0)
    metres = float(max(extents[0], extents[1] * width / height)) / (1 - 2 * margin)
    return Frame((scene.low + scene.high) / 2, metres, width, height)


def svg(scene: Scene, frame: Frame, title: str = "") -> str:
    """Return a picture as an `<svg>` element that needs nothing from outside.

    Lines on the ground and the scale bar take the text's colour, so it fits dark pages too.
    """
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {frame.width} {frame.height}" '
        f'role="img" font-family="sans-serif" stroke-linecap="round" stroke-linejoin="round">'
    ]
    if title:
        parts.append(f"<title>{escape(title)}</title>")
    parts.append('<g fill="none" stroke="currentColor" stroke-width="1" opacity="0.3">')
    for line in scene.ground:
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in frame.pixels(line))
        parts.append(f'<polyline points="{path}"/>')
    parts.append("</g>")
    for stroke in scene.strokes:
        for corners, colour, edge in _flat(stroke, frame):
            path = " ".join(f"{x:.2f},{y:.2f}" for x, y in corners.tolist())
            parts.append(
                f'<polygon points="{path}" fill="{colour}" stroke="{edge}" '
                f'stroke-width="{_THINNEST}"/>'
            )
        if stroke.faces:
            continue
        (x1, y1), (x2, y2) = frame.pixels(np.stack((stroke.start, stroke.end)))
        thick = max(_THINNEST, 2 * stroke.radius * frame.scale)
        # A line without length has no round ends in some browsers.
        x2 += 0.01
        for colour, width, lift in _layers(stroke.colour, thick):
            parts.append(
                f'<line x1="{x1:.2f}" y1="{y1 - lift:.2f}" x2="{x2:.2f}" y2="{y2 - lift:.2f}" '
                f'stroke="{colour}" stroke-width="{width:.2f}"/>'
            )
    for number, mark in enumerate(scene.marks, start=1):
        places = np.array(mark.places).reshape(-1, 2)
        parts += [_sign(x, y, number) for x, y in frame.pixels(places)]
        row = _ROW * number
        parts.append(
            f'{_sign(_ROW, row, number)}<text x="{1.8 * _ROW:.1f}" y="{row + 4.5:.1f}" '
            f'font-size="13" fill="currentColor">{escape(mark.text)}</text>'
        )
    length, bar = _scale_bar(frame)
    (x1, y1), (x2, _) = bar
    parts.append(
        f'<path d="M{x1:.1f} {y1 - 4:.1f}v8m0-4H{x2:.1f}m0-4v8" fill="none" '
        f'stroke="currentColor" stroke-width="1.5"/>'
        f'<text x="{(x1 + x2) / 2:.1f}" y="{y1 - 7:.1f}" text-anchor="middle" font-size="12" '
        f'fill="currentColor">{length:g} m</text></svg>'
    )
    return "".join(parts)


def image(scene: Scene, frame: Frame, caption: str = "", smooth: int = 2) -> Image:
    """Return a picture as RGB pixels.

    Args:
        scene: what to show.
        frame: which part of it, and the size in pixels.
        caption: one line at the top.
        smooth: drawn so many times larger and scaled down, which smooths its edges.
    """
    from PIL import Image as Images
    from PIL import ImageDraw, ImageFont

    fine = Frame(frame.centre, frame.metres, frame.width * smooth, frame.height * smooth)
    picture = Images.new("RGB", (fine.width, fine.height), "#f6f5f2")
    pen = ImageDraw.Draw(picture)
    for line in scene.ground:
        pen.line([tuple(p) for p in fine.pixels(line).tolist()], fill="#c9c7c1", width=smooth)
    for stroke in scene.strokes:
        for corners, colour, edge in _flat(stroke, fine):
            around = [tuple(corner) for corner in corners.tolist()]
            pen.polygon(around, fill=colour)
            pen.line([*around, around[0]], edge, round(_THINNEST * smooth), joint="curve")
        if stroke.faces:
            continue
        ends = fine.pixels(np.stack((stroke.start, stroke.end)))
        thick = max(_THINNEST * smooth, 2 * stroke.radius * fine.scale)
        for colour, width, lift in _layers(stroke.colour, thick):
            (x1, y1), (x2, y2) = (ends - (0, lift)).tolist()
            pen.line([(x1, y1), (x2, y2)], fill=colour, width=max(1, round(width)))
            for x, y in ((x1, y1), (x2, y2)):
                half = width / 2
                pen.ellipse([x - half, y - half, x + half, y + half], fill=colour)
    small = ImageFont.load_default(12.0 * smooth)
    for number, mark in enumerate(scene.marks, start=1):
        row = (_ROW * smooth, _ROW * smooth * (number + bool(caption)))
        places = np.array(mark.places).reshape(-1, 2)
        for x, y in (*fine.pixels(places).tolist(), row):
            half = _SIGN * smooth
            pen.ellipse([x - half, y - half, x + half, y + half], "#222222")
            pen.text((x, y), f"{number}", "#ffffff", small, anchor="mm")
        pen.text((1.8 * row[0], row[1]), mark.text, "#222222", small, anchor="lm")
    length, ((x1, y1), (x2, _)) = _scale_bar(fine)
    pen.line([(x1, y1), (x2, y1)], fill="#444444", width=2 * smooth)
    font = ImageFont.load_default(13.0 * smooth)
    pen.text(((x1 + x2) / 2, y1 - 4 * smooth), f"{length:g} m", "#444444", font, anchor="ms")
    if caption:
        pen.text((12 * smooth, 12 * smooth), shortened(caption, 200), "#222222", font)
    return picture.resize((frame.width, frame.height), Images.Resampling.BOX)


def save_picture(scene: Scene, path: Path, title: str = "", width: int = 800) -> None:
    """Write a picture; the suffix of `path`, `.svg` or `.png`, decides how.

    Raises:
        InputError: another suffix, or the file cannot be written.
    """
    frame = frame_around(scene, width, width * 3 // 4)
    # The legend stands above the robot.
    legend = round(_ROW * (len(scene.marks) - 1)) if scene.marks else 0
    centre = frame.centre + np.array([0, legend / 2 / frame.scale])
    frame = Frame(centre, frame.metres, width, frame.height + legend)
    try:
        if path.suffix.lower() == ".svg":
            path.write_text(svg(scene, frame, title) + "\n", encoding="utf-8")
        elif path.suffix.lower() == ".png":
            image(scene, frame, title).save(path)
        else:
            raise InputError(f"{path} is no picture that can be written; end it in .svg or .png")
    except OSError as error:
        raise cannot_write(path, error, "name another file") from None


def _flat(stroke: Stroke, frame: Frame) -> Iterator[tuple[Array, str, str]]:
    """Yield corners (n, 2) in pixels, colour and colour of the edge of each of a solid's faces."""
    for face in stroke.faces:
        colour = _brighter(stroke.colour, face.brightness)
        corners = frame.pixels(face.corners)
        # A solid that is hardly larger than its edge would be all edge.
        small = float(np.ptp(corners, axis=0).min()) < 4 * _THINNEST
        yield corners, colour, colour if small else _brighter(stroke.colour, _EDGE)


def _layers(colour: str, thick: float) -> tuple[tuple[str, float, float], ...]:
    """Return (colour, thickness, lift) of what makes a stroke look round: edge, body, light."""
    if thick < 4 * _THINNEST:
        return ((colour, thick, 0.0),)
    edge = min(3.0, max(1.0, 0.06 * thick))
    return (
        (_brighter(colour, _EDGE), thick, 0.0),
        (colour, thick - 2 * edge, 0.0),
        (_brighter(colour, _SHINE), 0.3 * thick, 0.2 * thick),
    )


def _brighter(colour: str, factor: float) -> str:
    channels = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{min(255, round(channel * factor)):02x}" for channel in channels)


def _sign(x: float, y: float, number: int) -> str:
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{_SIGN:g}" fill="#222" stroke="#fff"/>'
        f'<text x="{x:.1f}" y="{y + 4:.1f}" text-anchor="middle" font-size="11" fill="#fff">'
        f"{number}</text>"
    )


def _scale_bar(frame: Frame) -> tuple[float, tuple[tuple[float, float], tuple[float, float]]]:
    """Return a round length in m and the ends of a bar that long, in pixels."""
    length = nice_length(frame.metres / 4)
    right, bottom = frame.width * 0.97, frame.height * 0.96
    return length, ((right - length * frame.scale, bottom), (right, bottom))
