"""What MuJoCo cannot compile in a reasonable time is refused, in a process with limits."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from pathlib import Path

import mujoco
import pytest

from dog import DOG, write_dog
from robomore.errors import InputError
from robomore.importer import first_compile
from robomore.importer.first_compile import (
    LIMITS,
    answer,
    check_amounts,
    compile_content,
    compile_first,
)
from robomore.importer.motors import propose_motors
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.task_file import read_task
from robomore.plain_files import PlainFolder
from robomore.runs.loading import stored_task
from robomore.tasks.portable import task_content

LARGE = '<asset><hfield name="h" nrow="60000" ncol="60000" size="1 1 1 1"/></asset></mujoco>'


def test_a_file_that_takes_too_much_memory_is_refused(tmp_path: Path) -> None:
    """A few characters, for which MuJoCo takes 14 GB."""
    with pytest.raises(InputError, match=r"takes more than 2,048 MiB of memory; use fewer"):
        read_robot(write_dog(tmp_path, DOG.replace("</mujoco>", LARGE)))


def dawdle(payload: bytes, scratch: Path, report: object) -> bytes:
    """Compile for ever."""
    time.sleep(600)
    return b""


def test_a_file_that_takes_too_long_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(first_compile, "LIMITS", replace(LIMITS, wall_seconds=1.0))
    with pytest.raises(InputError, match=r"one: to compile it takes more than 1 s"):
        compile_first("one", f"{__name__}:dawdle", b"", b"too long")


def crash(payload: bytes, scratch: Path, report: object) -> bytes:
    """End the process as MuJoCo does with a model that contains itself."""
    import ctypes

    ctypes.string_at(0)
    return b""


def test_a_crash_of_the_parser_is_the_files_fault() -> None:
    with pytest.raises(InputError, match="one: to compile it makes MuJoCo crash; use fewer"):
        compile_first("one", f"{__name__}:crash", b"", b"crash")


def test_what_was_written_from_a_robot_is_not_compiled_apart_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = write_dog(tmp_path)
    file = write_proposal(read_robot(source), source, tmp_path / "dog")
    monkeypatch.delattr(first_compile, "run_sandboxed")
    assert read_task(file).parameters
    assert read_robot(source).xml


def test_a_foreign_task_is_compiled_apart_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = write_dog(tmp_path)
    task = read_task(write_proposal(read_robot(source), source, tmp_path / "dog"))
    content = json.loads(task_content(task)) | {"id": "foreign"}
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "task.json").write_text(json.dumps(content))
    assert stored_task(PlainFolder(folder), "foreign").id == "foreign"
    monkeypatch.delattr(first_compile, "run_sandboxed")
    assert stored_task(PlainFolder(folder), "foreign").id == "foreign"


def test_a_foreign_task_that_takes_too_long_in_each_step_is_refused(tmp_path: Path) -> None:
    source = write_dog(tmp_path)
    task = read_task(write_proposal(read_robot(source), source, tmp_path / "dog"))
    content = json.loads(task_content(task))
    content["template"] = content["template"].replace("<option", '<option iterations="100000"')
    with pytest.raises(InputError, match=r"100,000 iterations of the solver; the most is 1,000"):
        compile_content(json.dumps(content).encode())


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ('<option iterations="2000000000"/>', "2,000,000,000 iterations of the solver; the most"),
        ('<option noslip_iterations="5000"/>', "5,000 iterations of the friction solver"),
        ('<option timestep="1e-9"/>', "a time step of 1e-09 s; give one from 1e-05 to 0.1 s"),
        ('<option timestep="1e9"/>', "a time step of 1e[+]09 s"),
        ('<option gravity="0 0 inf"/>', "no finite number"),
        ('<size memory="500M"/>', "bytes of working memory"),
        ('<visual><global offwidth="100000"/></visual>', "100,000 pixels in width"),
        ("<worldbody>" + "<body><geom size='1'/></body>" * 500 + "</worldbody>", "501 links"),
    ],
)
def test_what_would_slow_each_step_is_refused(option: str, said: str) -> None:
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{option}</mujoco>")
    with pytest.raises(InputError, match=f"^robot has .*{said}"):
        check_amounts("robot", model)


@pytest.mark.parametrize("name", ["a\nb", "\x1b[31m", "\u202ex", "x" * 300])
def test_a_name_that_cannot_be_shown_is_refused(name: str, tmp_path: Path) -> None:
    shown = "".join(f"&#{ord(one)};" if ord(one) > 31 else "&#10;" for one in name)
    with pytest.raises(InputError, match="give it a name of at most 200 characters"):
        read_robot(write_dog(tmp_path, DOG.replace('"trunk" pos', f'"{shown}" pos')))


def test_a_large_file_is_not_read(tmp_path: Path) -> None:
    file = tmp_path / "robot.xml"
    with file.open("wb") as opened:
        opened.truncate(2**30)
    with pytest.raises(InputError, match="has more than 16 MiB"):
        read_robot(file)


def test_what_is_nested_too_deeply_is_said() -> None:
    def deep() -> None:
        raise RecursionError

    assert b"nested too deeply" in answer(deep)


def test_many_joints_get_motors_in_time() -> None:
    """The ends of the limbs are found once, and not for each joint."""
    legs = "".join(
        f'<body name="b{i}"><joint name="j{i}" axis="0 1 0"/><geom size="0.1"/></body>'
        for i in range(150)
    )
    trunk = f'<body name="t"><freejoint/><geom size="1"/>{legs}</body>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{trunk}</worldbody></mujoco>")
    assert sum(len(one.group.joints) for one in propose_motors(model)) == 150
