"""A template that makes much more than it holds is refused before MuJoCo takes the memory."""

from __future__ import annotations

import json
import tracemalloc
from dataclasses import replace
from pathlib import Path

import pytest

from dog import write_dog
from robomore.errors import InputError, InvalidMorphology
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.task_file import read_task
from robomore.plain_files import PlainFolder
from robomore.runs.loading import stored_task
from robomore.tasks import get_task
from robomore.tasks.portable import refuse_files, task_content, task_from_content
from robomore.tasks.repeats import expanded


@pytest.mark.parametrize(
    ("template", "said"),
    [
        ('<hfield nrow="100000" ncol="100000"/>', "asks for 10,000,000,000 values"),
        ('<hfield nrow="-100000" ncol="100000"/>', "values"),
        ('<asset><hfield nrow="{a}" ncol="2"/></asset>', "has nrow '{a}'; give a whole number"),
        ('<hfield nrow="1e9" ncol="2"/>', "give a whole number"),
        ('<texture width="99999" height="99999"/>', "<texture>"),
        ('<size nconmax="999999999"/>', "<size>"),
        ('<size memory="100G"/>', "asks for the memory '100G'"),
        ('<size memory="9999999k"/>', "asks for the memory"),
        ('<flexcomp count="100 100 100"/>', "more than 20,000 elements"),
        ('<replicate count="300"><replicate count="300"><a/></replicate></replicate>', "copies"),
        ('<repeat count="{a}"><a/></repeat>', "<repeat> in its template has count '{a}'"),
        ('<option timestep="{a}"/>', "<option> in its template depends on parameters"),
        ('<visual><quality shadowsize="{a}"/></visual>', "<visual> in its template depends"),
        ("<!-- -->", "holds comments or declares entities"),
        ("<a/>" * 20_001, "more than 20,000 elements"),
    ],
)
def test_what_is_too_large_is_named(template: str, said: str) -> None:
    with pytest.raises(InputError, match="task: ") as refused:
        refuse_files("task", f"<mujoco>{template}</mujoco>", {})
    assert said in str(refused.value)


def test_a_mesh_that_takes_long_is_refused() -> None:
    with pytest.raises(InputError, match=r"'a\.obj' has more than 16 MiB"):
        refuse_files("task", "<mujoco/>", {"a.obj": b"x" * (2**24 + 1)})


@pytest.mark.parametrize("id", ["../../x", "a/b", "task.toml", "\x1b[31m", "", "x" * 200])
def test_an_id_that_is_no_plain_name_is_refused(id: str, tmp_path: Path) -> None:
    source = write_dog(tmp_path)
    task = read_task(write_proposal(read_robot(source), source, tmp_path / "dog"))
    content = json.loads(task_content(task)) | {"id": id}
    with pytest.raises(InputError, match="it is no plain name"):
        task_from_content(json.dumps(content).encode(), trusted=False)


def test_usual_sizes_pass() -> None:
    refuse_files(
        "task",
        '<mujoco><size memory="10M" njmax="-1"/><asset><hfield nrow="200" ncol="200"/>'
        '<texture width="64" height="64"/></asset><replicate count="3"><geom/></replicate>'
        "</mujoco>",
        {},
    )


def test_repeats_within_repeats_have_a_limit_together() -> None:
    template = "<geom/>"
    for _ in range(5):
        template = f'<repeat count="64">{template}</repeat>'
    with pytest.raises(InvalidMorphology, match="more than 2,000 parts"):
        expanded(f"<mujoco>{template}</mujoco>", {})


@pytest.mark.parametrize(
    "content",
    [
        '{"options": {"x": [' + "1," * 3_000_000 + "1]}}",
        '{"template": "' + "x" * 5_000_000 + '"}',
        '{"assets": {"a": "' + "x" * 5_000_000 + '"}, "unit": "' + "x" * 5_000_000 + '"}',
        json.dumps({"description": "\n" * 3_000_000}),
    ],
    ids=["numbers", "template", "beside meshes", "escapes"],
)
def test_a_long_content_is_refused_before_it_is_read(content: str) -> None:
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match="besides meshes are read"):
            task_from_content(content.encode(), trusted=False)
        assert tracemalloc.get_traced_memory()[1] < 40 * 2**20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(("steps", "skip"), [(10**12, 1), (1000, 10**9), (-1, 1), (1000, 0)])
def test_an_episode_without_an_end_is_refused(steps: int, skip: object, tmp_path: Path) -> None:
    source = write_dog(tmp_path)
    task = read_task(write_proposal(read_robot(source), source, tmp_path / "dog"))
    content = json.loads(task_content(task))
    assert task_from_content(json.dumps(content).encode(), trusted=False).id == task.id
    content["episode_steps"], content["options"]["frame_skip"] = steps, skip
    with pytest.raises(InputError, match="steps of MuJoCo"):
        task_from_content(json.dumps(content).encode(), trusted=False)


@pytest.mark.parametrize(
    "options",
    [
        {"frame_skip": 2.5},
        {"frame_skip": True},
        {"home": [1]},
        {"home": {"FL_hip": 1e308}},
        {"upright": [1]},
        {"upright": ["a"] * 4},
        {"healthy_tilt": "x"},
        {"healthy_height": [1]},
        {"reset_noise": 1e308},
        {"reset_noise": -1},
        {"reach": 1e308},
        {"sensors": [5]},
        {"nonsense": 1},
        {"render_mode": "human"},
    ],
)
def test_options_that_no_robot_has_are_refused(options: dict, tmp_path: Path) -> None:
    source = write_dog(tmp_path)
    task = read_task(write_proposal(read_robot(source), source, tmp_path / "dog"))
    content = json.loads(task_content(task))
    content["options"] |= options
    with pytest.raises(InputError, match="its options are none of a robot"):
        task_from_content(json.dumps(content).encode(), trusted=False)


def test_an_id_in_a_folder_is_no_path(tmp_path: Path) -> None:
    """Else somebody else's folder could name a task file that is read, and whose code runs."""
    source = write_dog(tmp_path)
    file = write_proposal(read_robot(source), source, tmp_path / "dog")
    with pytest.raises(InputError, match="no task is called"):
        stored_task(PlainFolder(tmp_path), str(file))


@pytest.mark.parametrize(
    "expression",
    ["1/0", "9**9**9**9", "sqrt(0-1)", "(0-1)**0.5"],
)
def test_arithmetic_without_a_value_is_the_morphologys_fault(expression: str) -> None:
    ant = get_task("ant")
    task = replace(ant, template=ant.template.replace("<option", f'<option x="{{{expression}}}"'))
    with pytest.raises(InvalidMorphology, match="no value for these parameters") as refused:
        task.mjcf(task.reference)
    assert len(str(refused.value)) < 400


@pytest.mark.parametrize("expression", ["nobody", "(" * 500 + "1" + ")" * 500])
def test_what_is_no_arithmetic_is_refused_at_once(expression: str) -> None:
    ant = get_task("ant")
    with pytest.raises(InputError, match="template") as refused:
        replace(ant, template=ant.template.replace("<option", f'<option x="{{{expression}}}"'))
    assert len(str(refused.value)) < 400
