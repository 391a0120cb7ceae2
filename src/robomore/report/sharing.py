"""The picture by which a page is shared: champion and reference design side by side."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from typing import TYPE_CHECKING

from robomore.text import shortened

if TYPE_CHECKING:
    from robomore.rendering.drawing import Scene

WIDTH, HEIGHT = 1200, 630
"""What most services show."""


def share_image(scenes: Mapping[str, Scene], title: str) -> str:
    """Return the picture as a `data:` address; empty without any scene.

    Args:
        scenes: drawn robots by their names.
        title: one line.
    """
    from PIL import Image, ImageDraw, ImageFont

    from robomore.rendering.pictures import frame_around, image

    if not scenes:
        return ""
    canvas = Image.new("RGB", (WIDTH, HEIGHT), "#f6f5f2")
    pen = ImageDraw.Draw(canvas)
    width, top = WIDTH // len(scenes), 90
    for number, (name, scene) in enumerate(scenes.items()):
        frame = frame_around(scene, width, HEIGHT - top, alike=[*scenes.values()], margin=0.12)
        canvas.paste(image(scene, frame), (number * width, top))
        font = ImageFont.load_default(26.0)
        pen.text((number * width + 40, top), name, "#55585f", font)
    pen.text((40, 28), shortened(title), "#1d1f24", ImageFont.load_default(38.0))
    file = io.BytesIO()
    canvas.quantize(32).save(file, "PNG", optimize=True)
    return f"data:image/png;base64,{base64.b64encode(file.getvalue()).decode()}"
