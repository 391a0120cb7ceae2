"""Volumes that are read from templates."""

from __future__ import annotations

import math
from dataclasses import replace

import mujoco
import pytest

from paper import PAPER
from robomore.envs.compile import compile_model, model_volume
from robomore.errors import InputError
from robomore.tasks import TASKS, Capsule, get_task
from robomore.tasks.solids import solids
from robomore.tasks.template import fill

ANT = 0.18217601654147828

VOLUMES = {
    "ant": ANT,
    "ant-powered": ANT,
    "ant-desert": ANT,
    "ant-jump": ANT,
    "hopper": 0.015820013405927,
    "half-cheetah": 0.021183722813025697,
    "swimmer": 0.10681415022205296,
    "walker": 0.023677136632555076,
}
"""In m³, of the reference morphologies: summed by hand from lists of their solids."""


@pytest.mark.parametrize("id", VOLUMES)
def test_the_figures_of_the_paper_s_tasks(id: str) -> None:
    assert list(VOLUMES) == PAPER
    task = get_task(id)
    assert task.volume(task.reference) == pytest.approx(VOLUMES[id], rel=1e-14)
    assert model_volume(compile_model(task, task.reference)) == pytest.approx(VOLUMES[id])


def test_equal_legs_are_one_solid_with_a_count() -> None:
    ant = TASKS["ant"]
    legs = [one for one in ant.solids(ant.named(ant.reference)) if isinstance(one, Capsule)]
    assert [one.count for one in legs] == [4, 4, 4]


@pytest.mark.parametrize(
    ("sizes", "merged"),
    [
        (("{min(a, b)} 1", "{a} 1"), 0),
        (("{max(a, b)} 1", "{b} 1"), 0),
        (("{a} {0.5 + abs(b - a)}", "{a} {0.5 + b - a}"), 0),
        (("{a} {0.5 + sqrt((b - a)**2)}", "{a} {0.5 + b - a}"), 0),
        (("{a} {0.5 + ((b - a)**2)**0.5}", "{a} {0.5 + b - a}"), 0),
        # Names that follow one another in the alphabet are no row of equal steps.
        (("{a} {1 + b - a}", "{a} {1 + c - b}"), 0),
        (("{a} {sin(b)**2 + cos(b)**2}", "{a} 1"), 1),
        (("{a} {(b + c)**2}", "{a} {b**2 + 2*b*c + c**2}"), 1),
    ],
)
def test_capsules_are_one_where_they_are_equal_whatever_the_parameters(
    sizes: tuple[str, ...], merged: int
) -> None:
    geoms = "".join(f'<geom type="capsule" size="{size}"/>' for size in sizes)
    template = f"<mujoco><worldbody><body>{geoms}</body></worldbody></mujoco>"
    for values in ({"a": 0.3, "b": 0.2, "c": 0.6}, {"a": 0.1, "b": 0.5, "c": 0.2}):
        found = solids(template, values)
        assert len(found) == len(sizes) - merged
        radii, halves = zip(*(map(float, fill(one, values).split()) for one in sizes), strict=True)
        by_hand = [Capsule(r, 2 * h).volume for r, h in zip(radii, halves, strict=True)]
        assert sum(one.volume for one in found) == pytest.approx(sum(by_hand))


def test_a_link_that_is_as_thick_as_the_thinner_of_two_has_its_own_volume() -> None:
    swimmer = get_task("swimmer")
    template = swimmer.template
    for own, other in (
        ("{-back_length}", "{-middle_length}"),
        ("{middle_radius}", "{min(middle_radius, front_radius)}"),
        ("{back_radius}", "{front_radius}"),
    ):
        assert own in template
        template = template.replace(own, other)
    parameters = tuple(p for p in swimmer.parameters if not p.name.startswith("back"))
    task = replace(
        swimmer, id="eel", template=template, parameters=parameters, rules=(), search_rules=()
    )
    thin = dict(zip(task.names, task.reference, strict=True))
    thin |= {"front_radius": 0.2, "middle_radius": 0.05}
    compiled = model_volume(compile_model(task, thin))
    assert compiled == pytest.approx(0.3267, abs=1e-4)
    assert task.volume(thin) == pytest.approx(compiled)


def test_every_kind_of_solid_with_defaults_by_class() -> None:
    template = """<mujoco>
      <default><geom type="box" size="1 2 3"/>
        <default class="thin"><geom type="cylinder" size="{r} 0.5"/></default></default>
      <worldbody><geom type="plane" size="1 1 1"/><body childclass="thin">
        <geom/><geom class="main"/><geom type="ellipsoid" size="1 1 1"/>
        <geom contype="0" conaffinity="0" size="9 9 9"/>
        <frame><body><geom type="mesh" mesh="m"/></body></frame>
      </body></worldbody>
      <asset><mesh name="m" scale="2 {r} 1"/></asset></mujoco>"""
    template = template.replace('class="main"', 'type="box" size="1 2 3"')
    found = [one.volume for one in solids(template, {"r": 0.1}, {"m": 10.0})]
    assert found == pytest.approx([math.pi * 0.01, 48, 4 / 3 * math.pi, 2.0])


@pytest.mark.parametrize("kind", ["capsule", "cylinder", "ellipsoid", "box"])
@pytest.mark.parametrize("size", ["0.1", "0.1 0.3 0.4"])
def test_a_solid_between_two_ends_has_its_volume_in_mujoco(kind: str, size: str) -> None:
    geom = f'<geom type="{kind}" fromto="0 0 0 0 0.6 0.8" size="{size}"/>'
    template = f"<mujoco><worldbody><body>{geom}</body></worldbody></mujoco>"
    (solid,) = solids(template, {})
    compiled = mujoco.MjModel.from_xml_string(template)
    assert solid.volume == pytest.approx(model_volume(compiled))


def test_code_in_a_template_is_refused() -> None:
    geom = '<geom size="{().__class__}"/>'
    with pytest.raises(ValueError, match="not plain arithmetic"):
        solids(f"<mujoco><worldbody><body>{geom}</body></worldbody></mujoco>", {})


def test_a_typo_in_a_template_is_named() -> None:
    swimmer = get_task("swimmer")
    wrong = swimmer.template.replace("{front_radius}", "{front_radus}")
    assert wrong != swimmer.template
    with pytest.raises(InputError, match=r"uses 'front_radus', which is neither .* front_radius"):
        replace(swimmer, template=wrong)


def test_a_template_that_reads_a_file_says_how_it_travels() -> None:
    swimmer = get_task("swimmer")
    mesh = '<asset><mesh name="shell" file="meshes/shell.obj"/></asset><worldbody>'
    with pytest.raises(InputError, match=r"reads the file 'meshes/shell\.obj'.* into `assets`"):
        replace(swimmer, template=swimmer.template.replace("<worldbody>", mesh))


def test_sizes_are_computed_with_floats_as_the_template_is_filled() -> None:
    # Whole numbers that differ by 1, and that are the same as floats.
    size = "{1 + 9007199254740993 - 9007199254740992 - 1}"
    (ball,) = solids(
        f'<mujoco><worldbody><body><geom size="{size}"/></body></worldbody></mujoco>', {}
    )
    assert ball.radius == float(fill(size, {}))
