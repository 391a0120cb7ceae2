"""What is free in a robot is marked in its picture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from robomore.rendering.drawing import PALETTE, draw
from robomore.rendering.marks import draw_free
from robomore.rendering.pictures import save_picture
from robomore.tasks import get_task
from robomore.tasks.task import Parameter

ANT = get_task("ant")


def test_parameters_are_marked_on_the_parts_that_they_change() -> None:
    scene = draw_free(ANT)
    texts = {mark.text: len(mark.places) for mark in scene.marks}
    assert texts == {
        "torso_radius": 1,
        "hip_x, hip_y, hip_radius": 4,
        "leg_x, leg_y, leg_radius": 4,
        "foot_x, foot_y, foot_radius": 4,
    }
    colours = {stroke.colour for stroke in scene.strokes}
    assert colours <= set(PALETTE)
    middles = [(one.start + one.end) / 2 for one in scene.strokes]
    for mark in scene.marks:
        for place in mark.places:
            assert any(np.allclose(place, middle) for middle in middles)


def test_what_is_fixed_is_grey_and_strength_is_marked_where_it_acts() -> None:
    whole = replace(
        ANT,
        parameters=(Parameter("gear", 50, 300, 150, "strength of the motors"),),
        constants=dict(zip(ANT.names, ANT.reference, strict=True)),
        rules=(),
        search_rules=(),
        options=lambda values: {},
    )
    scene = draw_free(whole)
    (mark,) = scene.marks
    assert mark.text == "gear" and len(mark.places) == 8, "each leg and foot, and not the torso"
    grey = [stroke for stroke in scene.strokes if stroke.colour not in PALETTE]
    assert len(grey) == len(scene.strokes) - 8
    assert [s.geom for s in scene.strokes] == [s.geom for s in draw(ANT, ANT.reference).strokes]


def test_counts_are_marked_at_the_root_and_parts_that_are_not_there_are_said() -> None:
    marks = {mark.text: len(mark.places) for mark in draw_free(get_task("crawler")).marks}
    assert marks["legs, segments, torso_radius"] == 1
    assert marks["lower_length, lower_radius: no part of the reference robot"] == 0


@pytest.mark.parametrize("suffix", [".svg", ".png"])
def test_a_picture_has_a_legend_above_the_robot(suffix: str, tmp_path: Path) -> None:
    from PIL import Image

    scene, file = draw_free(ANT), tmp_path / f"ant{suffix}"
    save_picture(scene, file, "Ant & more")
    if suffix == ".png":
        plain = tmp_path / "plain.png"
        save_picture(replace(scene, marks=()), plain, "Ant & more")
        with Image.open(file) as marked, Image.open(plain) as bare:
            assert marked.height == bare.height + 66 and marked.width == bare.width
        return
    text = file.read_text(encoding="utf-8")
    assert all(mark.text in text for mark in scene.marks)
    assert text.count("<circle") == sum(len(mark.places) for mark in scene.marks) + 4
