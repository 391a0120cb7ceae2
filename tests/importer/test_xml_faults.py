"""What MuJoCo finds wrong with a file is said in one line, with the place."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from robomore.errors import InputError
from robomore.importer.reading import read_robot
from tripod import STEADY, write_tripod

INCLUDED = '<mujocoinclude><worldbody><body><geom siz="1"/></body></worldbody></mujocoinclude>'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            '<mujoco>\n<worldbody>\n<body><geom siz="1"/></body></worldbody></mujoco>',
            ", line 3: MuJoCo does not read it: unrecognized attribute: 'siz' in <geom>; correct",
        ),
        (
            "<mujoco>\n<worldbody>\n<body></worldbody></mujoco>",
            ", line 3: .* not well-formed XML (mismatched element) in <body>; correct the file",
        ),
        ("hello", ", line 1: MuJoCo does not read it: it is not well-formed XML (parsing text)"),
        (
            STEADY.replace('joint="L_hip"', 'joint="L_hp"'),
            ", line 3\\d: MuJoCo does not read it: unknown transmission target 'L_hp' .*; correct",
        ),
        (
            '<mujoco>\n<include file="inner.xml"/></mujoco>',
            ": MuJoCo does not read it: unrecognized attribute: 'siz' in <geom>; correct the file",
        ),
        ("", " is no robot that MuJoCo reads: empty file '.*'"),
    ],
)
def test_the_file_the_line_and_the_element_are_named(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "inner.xml").write_text(INCLUDED)
    file = write_tripod(tmp_path, text)
    pattern = said.replace("(", r"\(").replace(")", r"\)")
    with pytest.raises(InputError, match=f"^{file}{pattern}") as refused:
        read_robot(file)
    assert "\n" not in str(refused.value) and "Error" not in str(refused.value)


def test_what_is_no_file_is_said(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.xml")
    with pytest.raises(InputError, match=r"pipe\.xml is a named pipe\. Name the robot's MJCF"):
        read_robot(tmp_path / "pipe.xml")
    with pytest.raises(InputError, match=r" is a folder\. Name the robot's MJCF"):
        read_robot(tmp_path)
    write_tripod(tmp_path)
    with pytest.raises(InputError, match=r"no file .*/tripd\.xml\. Did you mean '.*/tripod\.xml'"):
        read_robot(tmp_path / "tripd.xml")
    (tmp_path / "link.xml").symlink_to("tripod.xml")
    assert read_robot(tmp_path / "link.xml").xml
