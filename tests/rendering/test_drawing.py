"""Bodies drawn without OpenGL: the right solids, in the right place, at the right size."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mujoco
import numpy as np
import pytest

from robomore.envs.compile import compile_model
from robomore.errors import InputError, InvalidMorphology
from robomore.rendering.drawing import (
    Array,
    Scene,
    draw,
    elevation,
    ground_lines,
    nice_length,
    project,
    rest_pose,
    view_of,
)
from robomore.rendering.pictures import Frame, frame_around, image, save_picture, svg
from robomore.tasks import TASKS, get_task


@pytest.mark.parametrize("name", TASKS)
def test_every_robot_is_drawn_part_by_part(name: str) -> None:
    task = TASKS[name]
    scene = draw(task, task.reference)
    model = compile_model(task, task.reference)
    robot = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom]]
    assert len(scene.strokes) == len(robot)
    assert np.isfinite(scene.low).all()
    assert (scene.high > scene.low).all()
    assert scene.ground


def test_the_swimmer_lies_stretched_out_as_seen_from_above() -> None:
    task = get_task("swimmer")
    scene = draw(task, {**task.named(task.reference), "front_length": 2.0, "back_radius": 0.05})
    lengths = sorted(float(np.linalg.norm(s.end - s.start)) for s in scene.strokes)
    assert lengths == pytest.approx([1.0, 1.0, 2.0])
    assert sorted(stroke.radius for stroke in scene.strokes) == pytest.approx([0.05, 0.1, 0.1])
    width, height = scene.high - scene.low
    assert (width, height) == pytest.approx((4.0 + 0.1 + 0.05, 0.2))


def test_the_hopper_stands_upright_as_seen_from_the_side() -> None:
    task = get_task("hopper")
    scene = draw(task, task.reference)
    values = task.named(task.reference)
    assert scene.high[1] == pytest.approx(values["torso_top"] + values["torso_radius"])
    # It walks to the right: the foot's tip is farther from the leg than its heel.
    foot = min(scene.strokes, key=lambda stroke: stroke.start[1] + stroke.end[1])
    assert max(foot.start[0], foot.end[0]) == pytest.approx(values["foot_front"])


def test_the_ant_stands_on_the_ground_with_its_ankles_within_their_range() -> None:
    model = compile_model(get_task("ant"), get_task("ant").reference)
    qpos = rest_pose(model)
    limited = model.jnt_limited.astype(bool)
    at = qpos[model.jnt_qposadr[limited]]
    assert (at >= model.jnt_range[limited, 0]).all()
    assert (at <= model.jnt_range[limited, 1]).all()
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    feet = [g for g in range(model.ngeom) if "ankle" in model.geom(g).name]
    lowest = min(
        data.geom_xpos[g, 2] - abs(data.geom_xmat[g, 8]) * model.geom_size[g, 1]
        - model.geom_size[g, 0]
        for g in feet
    )  # fmt: skip
    assert lowest == pytest.approx(0.0, abs=1e-9)


def test_near_parts_are_drawn_over_far_ones() -> None:
    scene = draw(get_task("ant"), get_task("ant").reference)
    depths = [stroke.depth for stroke in scene.strokes]
    assert depths == sorted(depths)
    assert depths[0] < depths[-1]


def seen(geom: str, joint: str = "<joint type='hinge' axis='0 1 0'/>") -> Scene:
    """Return the picture of a robot of one solid; with a hinge it is seen from the side."""
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><asset><mesh name='wedge' vertex='0 0 0 .4 0 0 0 .2 0 0 0 .6'/></asset>"
        f"<worldbody><body>{joint}<geom {geom}/></body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return project(model, data, view_of(model))


def area(corners: Array) -> float:
    x, y = corners.T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2


@pytest.mark.parametrize(
    ("geom", "size", "filled"),
    [
        ("type='box' size='.1 .2 .5'", (0.2, 1.0), 0.2),
        ("type='box' size='.1 .2 .5' euler='0 90 0'", (1.0, 0.2), 0.2),
        ("type='cylinder' size='.1 .3'", (0.2, 0.6), 0.12),
        ("type='cylinder' size='.1 .3' euler='90 0 0'", (0.2, 0.2), np.pi * 0.01),
        ("type='ellipsoid' size='.1 .2 .5'", (0.2, 1.0), np.pi * 0.05),
        ("type='mesh' mesh='wedge'", (0.4, 0.6), 0.12),
    ],
)
def test_other_solids_have_their_own_outline(
    geom: str, size: tuple[float, float], filled: float
) -> None:
    scene = seen(geom)
    assert scene.high - scene.low == pytest.approx(size, rel=0.01)
    (stroke,) = scene.strokes
    (face,) = stroke.faces
    assert area(face.corners) == pytest.approx(filled, rel=0.02)


def test_of_a_box_three_sides_are_seen_from_above_and_its_top_is_lightest() -> None:
    scene = seen("type='box' size='.1 .2 .5'", "<freejoint/>")
    (stroke,) = scene.strokes
    assert len(stroke.faces) == 3
    a, e = np.radians(-65.0), np.radians(24.0)
    facing = np.abs([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])
    areas = [area(face.corners) for face in stroke.faces]
    assert areas == pytest.approx(np.array([0.4, 0.2, 0.08]) * facing)
    # They touch and do not overlap, and all are on the near side: the nearest corner is in each.
    shared = set.intersection(
        *({tuple(np.round(c, 9)) for c in face.corners} for face in stroke.faces)
    )
    assert len(shared) == 1
    assert np.argmax([face.brightness for face in stroke.faces]) == 2


def test_a_box_stands_on_the_ground_in_a_picture() -> None:
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body pos='0 0 3'><freejoint/><geom type='box' size='.3 .2 .05'/>"
        "</body></worldbody></mujoco>"
    )
    assert rest_pose(model)[2] == pytest.approx(0.05)


@pytest.mark.parametrize("joint", ["<freejoint/>", "<joint type='hinge' axis='0 1 0'/>"])
def test_pictures_of_a_box_fill_it(joint: str) -> None:
    scene = seen("type='box' size='.1 .2 .5'", joint)
    frame = frame_around(scene, 200, 150)
    root = ElementTree.fromstring(svg(scene, frame))
    (stroke,) = scene.strokes
    drawn = root.findall("{http://www.w3.org/2000/svg}polygon")
    assert len(drawn) == len(stroke.faces) and not root.findall("{http://www.w3.org/2000/svg}line")
    picture = image(scene, frame)
    for face in stroke.faces:
        corners = frame.pixels(face.corners)
        # Close to each corner, where a capsule would leave the background.
        for x, y in corners + 0.15 * (corners.mean(axis=0) - corners):
            red, _, blue = picture.getpixel((int(x), int(y)))  # type: ignore[misc]
            assert red > blue + 40, "the colour of a torso is orange"


def test_the_elevation_is_that_of_the_height_field() -> None:
    task = get_task("ant-desert")
    assert task.terrain is not None
    model = compile_model(task, task.reference)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    height = elevation(task.terrain)
    geom = np.zeros(1, np.int32)
    # On the height field's own grid points, where no interpolation differs from another.
    for x, y in ((10.0, -4.5), (70.0, 33.0), (-20.5, 7.0)):
        start = np.array([x, y, 10.0])
        away = mujoco.mj_ray(model, data, start, np.array([0.0, 0.0, -1.0]), None, 1, -1, geom)
        assert 10.0 - away == pytest.approx(
            float(height(np.array([x]), np.array([y]))[0]), abs=1e-6
        )


def test_ticks_stand_at_round_places() -> None:
    view = view_of(compile_model(get_task("hopper"), get_task("hopper").reference))
    profile, *ticks = ground_lines(view, np.array([10.3, 0.0, 1.0]), reach=1.0, spacing=0.5)
    assert [float(tick[0, 0]) for tick in ticks] == pytest.approx([9.5, 10.0, 10.5, 11.0])
    assert profile[:, 1] == pytest.approx(np.zeros(len(profile)))


@pytest.mark.parametrize(("most", "nice"), [(1.0, 1.0), (1.9, 1.0), (0.34, 0.2), (70.0, 50.0)])
def test_nice_lengths(most: float, nice: float) -> None:
    assert nice_length(most) == pytest.approx(nice)


def test_svg_has_the_size_of_the_body_and_escapes_its_title() -> None:
    task = get_task("swimmer")
    scene = draw(task, task.reference)
    root = ElementTree.fromstring(svg(scene, Frame(np.zeros(2), 4.0, 400, 300), "a <b>"))
    name = "{http://www.w3.org/2000/svg}"
    assert root.findtext(f"{name}title") == "a <b>"
    thickest = max(float(line.get("stroke-width", 0)) for line in root.iter(f"{name}line"))
    assert thickest == pytest.approx(2 * 0.1 * 100)


def test_bodies_in_frames_alike_have_one_scale() -> None:
    task = get_task("swimmer")
    small, large = (
        draw(task, {**task.named(task.reference), "front_length": length}) for length in (0.2, 3.0)
    )
    frames = [frame_around(scene, 400, 300, alike=[small, large]) for scene in (small, large)]
    assert frames[0].scale == pytest.approx(frames[1].scale)
    corners = frames[1].pixels(np.stack((large.low, large.high)))
    assert (corners >= 0).all()
    assert (corners <= (400, 300)).all()


def test_pixels_show_the_torso_where_it_is() -> None:
    task = get_task("hopper")
    scene = draw(task, task.reference)
    frame = frame_around(scene, 200, 150)
    picture = np.asarray(image(scene, frame))
    assert picture.shape == (150, 200, 3)
    torso = max(scene.strokes, key=lambda stroke: stroke.start[1] + stroke.end[1])
    x, y = frame.pixels((torso.start + torso.end) / 2).astype(int)
    red, green, blue = picture[y, x].tolist()
    assert red > green > blue
    assert picture[2, 100].tolist() == [246, 245, 242]


def test_pictures_are_written_by_their_suffix(tmp_path: Path) -> None:
    scene = draw(get_task("walker"), get_task("walker").reference)
    save_picture(scene, tmp_path / "a.svg")
    save_picture(scene, tmp_path / "a.PNG")
    assert (tmp_path / "a.svg").read_text().startswith("<svg")
    assert (tmp_path / "a.PNG").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(InputError, match=r"\.svg or \.png"):
        save_picture(scene, tmp_path / "a.bmp")
    with pytest.raises(InputError, match="another file"):
        save_picture(scene, tmp_path / "nowhere" / "a.svg")


def test_a_body_out_of_bounds_is_not_drawn() -> None:
    with pytest.raises(InvalidMorphology):
        draw(get_task("swimmer"), [99.0] * 6)
