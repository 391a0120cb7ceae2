"""A template that makes much more than it holds is refused before MuJoCo takes the memory."""

from __future__ import annotations

import json
import tracemalloc

import pytest

from robomore.errors import InputError, InvalidMorphology
from robomore.tasks.portable import refuse_files, task_from_content
from robomore.tasks.repeats import expanded


@pytest.mark.parametrize(
    ("template", "said"),
    [
        ('<hfield nrow="100000" ncol="100000"/>', "asks for 10,000,000,000 values"),
        ('<hfield nrow="-100000" ncol="100000"/>', "values"),
        ('<hfield nrow="{a}" ncol="2"/>', "has nrow '{a}'; give a whole number"),
        ('<hfield nrow="1e9" ncol="2"/>', "give a whole number"),
        ('<texture width="99999" height="99999"/>', "<texture>"),
        ('<size nconmax="999999999"/>', "<size>"),
        ('<size memory="100G"/>', "asks for the memory '100G'"),
        ('<size memory="9999999k"/>', "asks for the memory"),
        ('<flexcomp count="100 100 100"/>', "more than 20,000 elements"),
        ('<replicate count="300"><replicate count="300"><a/></replicate></replicate>', "copies"),
        ("<a/>" * 20_001, "more than 20,000 elements"),
    ],
)
def test_what_is_too_large_is_named(template: str, said: str) -> None:
    with pytest.raises(InputError, match="task: ") as refused:
        refuse_files("task", f"<mujoco>{template}</mujoco>", {})
    assert said in str(refused.value)


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
    with pytest.raises(InvalidMorphology, match="more than 20,000 parts"):
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
