"""Pieces for a printer: closed files of the stated volume, and what is not printable."""

from __future__ import annotations

import io

import mujoco
import numpy as np
import pytest
import trimesh

from robomore.envs.compile import compile_model
from robomore.errors import InputError
from robomore.export.printing import Printer, fitting_scale, pieces_of
from robomore.export.stl import stl_bytes
from robomore.tasks import TASKS, get_task


def robot(bodies: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")


@pytest.mark.parametrize(
    "task",
    ["hopper", *(pytest.param(t, marks=pytest.mark.exhaustive) for t in TASKS if t != "hopper")],
)
def test_files_are_closed_and_have_the_stated_volume(task: str) -> None:
    chosen = get_task(task)
    model = compile_model(chosen, chosen.reference)
    pieces = pieces_of(model, Printer(scale=0.1))
    assert [piece.name for piece in pieces][-1] == "whole" and len(pieces) > 2
    for piece in pieces:
        assert not any("closed" in fault or "volume" in fault for fault in piece.faults)
        stl = trimesh.load_mesh(io.BytesIO(piece.stl), file_type="stl")
        packed = trimesh.load_mesh(io.BytesIO(piece.threemf), file_type="3mf", process=False)
        for mesh in (stl, packed):
            assert mesh.is_watertight
            assert mesh.volume == pytest.approx(piece.volume, rel=1e-3)
    whole, parts = pieces[-1].volume, sum(piece.volume for piece in pieces[:-1])
    assert 0 < whole < parts < chosen.volume(chosen.reference) * 1e6 * 1.001


def test_a_piece_has_its_true_size() -> None:
    model = robot(
        '<body><freejoint/><geom type="capsule" fromto="0 0 0 .1 .1 0" size=".02"/>'
        '<body pos=".3 0 0"><geom type="sphere" size=".01"/></body></body>'
    )
    first, whole = pieces_of(model, Printer(wall=21.0, bed=(400.0, 400.0, 400.0)))
    length, (longest, *_) = 1000 * np.sqrt(0.02), whole.extent
    # Bodies without a joint between them are one piece, which does not hold together here.
    assert first.volume == whole.volume and not first.printable
    assert any("falls into 2 pieces" in fault for fault in first.faults)
    capsule = np.pi * 20**2 * (length + 80 / 3)
    assert first.volume == pytest.approx(capsule + 4 / 3 * np.pi * 10**3, rel=0.01)
    assert longest == pytest.approx(330, rel=0.05)
    assert first.wall == pytest.approx(20, rel=0.02)
    assert any("thinnest wall" in fault for fault in first.faults)


def test_what_does_not_fit_or_would_stick_together_is_not_printable() -> None:
    model = robot(
        '<body name="torso"><freejoint/><geom type="box" size=".05 .05 .05"/>'
        '<body name="a" pos="0 0 .05"><joint/>'
        '<geom type="capsule" fromto="0 0 0 .1 0 0" size=".005"/></body>'
        '<body name="b" pos="0 0 .05"><joint/>'
        '<geom type="capsule" fromto="0 .0105 0 .1 .0105 0" size=".005"/></body></body>'
    )
    good = pieces_of(model, Printer())
    assert [piece.name for piece in good] == ["torso", "a", "b", "whole"]
    assert good[0].printable and good[0].extent == pytest.approx((100, 100, 100), rel=1e-6)
    assert good[0].wall == pytest.approx(100, rel=1e-3)
    # Half a millimetre lies between the two bars.
    assert good[-1].printable
    assert not pieces_of(model, Printer(gap=0.6))[-1].printable
    small = Printer(bed=(90.0, 200.0, 200.0))
    cut = pieces_of(model, small)
    assert not cut[0].printable and "the bed" in cut[0].faults[0]
    assert cut[1].printable
    scale = fitting_scale(cut, small)
    assert 0.5 < scale < 0.95
    told = Printer(bed=small.bed, scale=float(f"{scale:.3g}"))
    assert all("the bed" not in fault for one in pieces_of(model, told) for fault in one.faults)


def test_a_rod_longer_than_the_bed_may_lie_across_it() -> None:
    rod = robot('<body name="rod"><freejoint/><geom type="box" size=".15 .01 .01"/></body>')
    usual = Printer()
    pieces = pieces_of(rod, usual)
    assert all(piece.printable for piece in pieces)
    across = (300 + 20) / np.sqrt(2)
    assert pieces[0].extent == pytest.approx((across, across, 20), rel=1e-5)
    assert fitting_scale(pieces, usual) == pytest.approx(256 / across, rel=0.01)
    # No turn helps on a bed that is a strip.
    strip = Printer(bed=(256.0, 30.0, 30.0))
    long = pieces_of(rod, strip)
    assert long[0].faults == ("it is 300 x 20 x 20 mm and the bed 256 x 30 x 30 mm",)
    assert fitting_scale(long, strip) == pytest.approx(256 / 300, rel=0.01)


@pytest.mark.parametrize(
    "wrong", [{"scale": 0.0}, {"wall": -1.0}, {"bed": (1.0, float("inf"), 1.0)}]
)
def test_numbers_without_sense_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(InputError, match=f"--{next(iter(wrong))}"):
        Printer(**wrong).check()  # type: ignore[arg-type]


def test_an_stl_file_has_the_triangles_in_it() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float64)
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    again = trimesh.load_mesh(io.BytesIO(stl_bytes(corners, faces)), file_type="stl")
    assert again.is_watertight and again.volume == pytest.approx(1 / 6)
