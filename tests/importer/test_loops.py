"""Closed chains and tendons follow the lengths of their links, or these are refused."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from robomore.envs.compile import compile_model
from robomore.envs.rest_pose import starting_pose
from robomore.errors import InputError
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.task_file import ReadTask, read_task_file

CHAIN = """<mujoco model="chain"><compiler angle="radian"/><worldbody>
<body name="base" pos="0 0 0.6"><freejoint/><geom type="box" size="0.15 0.1 0.03" mass="3"/>
<site name="high" pos="-0.1 0 0"/>
<body name="crank" pos="-0.1 0 0"><joint name="c" axis="0 1 0" range="-1.5 1.5"/>
<geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02"/>
<body name="coupler" pos="0 0 -0.2"><joint name="cc" axis="0 1 0" range="-1.5 1.5"/>
<site name="low" pos="0 0 0"/>
<geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.015"/></body></body>
<body name="rocker" pos="0.1 0 0"><joint name="r" axis="0 1 0" range="-1.5 1.5"/>
<geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02"/></body></body></worldbody>{ties}
<actuator><motor name="c" joint="c" gear="20" ctrlrange="-1 1"/></actuator></mujoco>"""
TIES = {
    "connect": '<equality><connect name="loop" body1="coupler" body2="rocker" anchor="0.2 0 0"/>'
    "</equality>",
    "weld": '<equality><weld name="loop" body1="rocker" body2="coupler" anchor="0.2 0 0"/>'
    "</equality>",
}
TENDON = '<tendon><spatial name="cord" {}><site site="high"/><site site="low"/></spatial></tendon>'


def task(folder: Path, ties: str, *free: str, of: str = "") -> ReadTask:
    """Return the task that is proposed for the chain, with `of` in its first parameter."""
    source = folder / "chain.xml"
    source.write_text(CHAIN.format(ties=ties))
    file = write_proposal(read_robot(source), source, folder / "task", free)
    if of:
        file.write_text(file.read_text().replace('of = ["crank"]', f"of = {of}"))
    return read_task_file(file)


def at_rest(read: ReadTask, factor: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = compile_model(read.task, [factor * value for value in read.task.reference])
    data = mujoco.MjData(model)
    data.qpos[:] = starting_pose(read.task, model)
    mujoco.mj_forward(model, data)
    return model, data


@pytest.mark.parametrize("kind", TIES)
@pytest.mark.parametrize("factor", [0.6, 1.0, 1.8])
def test_a_chain_stays_closed_when_its_links_change_together(
    tmp_path: Path, kind: str, factor: float
) -> None:
    read = task(tmp_path, TIES[kind], "crank_length", of='["crank", "rocker"]')
    model, data = at_rest(read, factor)
    assert data.ne == (3 if kind == "connect" else 6)
    assert np.abs(data.efc_pos[: data.ne]).max() < 1e-5
    lower = data.site_xpos[[model.eq_obj1id[0], model.eq_obj2id[0]]]
    foot = data.body("rocker").xpos - (0, 0, 0.2 * factor)
    assert lower == pytest.approx(np.stack((foot, foot)), abs=1e-5)


@pytest.mark.parametrize("kind", TIES)
@pytest.mark.parametrize("link", ["crank", "coupler"])
def test_a_length_that_opens_a_chain_is_refused(tmp_path: Path, kind: str, link: str) -> None:
    said = rf"with {link}_length = 0\.1 m the loop `loop` is open by 0\.1 m.*change all links"
    with pytest.raises(InputError, match=said):
        task(tmp_path, TIES[kind], f"{link}_length")


@pytest.mark.parametrize("kind", TIES)
def test_none_is_proposed_for_a_closed_chain(tmp_path: Path, kind: str) -> None:
    assert "crank_length" in task(tmp_path, "").task.names
    free = task(tmp_path, TIES[kind]).task.names
    assert free == ("crank_radius", "coupler_radius", "rocker_radius")


def test_a_length_that_leaves_the_range_of_a_tendon_is_refused(tmp_path: Path) -> None:
    short = TENDON.format('limited="true" range="0 0.25"')
    with pytest.raises(InputError, match=r"crank_length = 0\.4 m the tendon `cord` .* by 0\.15 m"):
        task(tmp_path, short, "crank_length")
    assert task(tmp_path, short).task.names[0] == "crank_radius"
    wide = TENDON.format('limited="true" range="0 0.45"')
    assert task(tmp_path, wide, "crank_length").task.names == ("crank_length",)


def test_a_tendons_spring_rests_at_its_length_unless_the_file_says_another(tmp_path: Path) -> None:
    for stated, wanted in (("", 0.3), ('springlength="0.15"', 0.15)):
        read = task(tmp_path, TENDON.format(f'stiffness="9" {stated}'), "crank_length")
        model, data = at_rest(read, 1.5)
        assert data.ten_length == pytest.approx([0.3])
        assert model.tendon_lengthspring[0] == pytest.approx([wanted, wanted])
