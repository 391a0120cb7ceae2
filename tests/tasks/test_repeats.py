"""Parts of a template that are repeated."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest

from robomore.errors import InvalidMorphology
from robomore.tasks.repeats import MOST, expanded, indices, repeats

ARMS = """<mujoco><worldbody><body name="hub">
<repeat count="{arms}" index="arm"><body name="arm_{arm}" pos="{arm/arms} 0 {length}">
<repeat count="{links - 1}" index="link">
<geom name="geom_{arm}_{link}" size="{armour*link}"/></repeat>
</body></repeat></body></worldbody></mujoco>"""


def names(text: str, tag: str) -> list[str]:
    return [part.attrib["name"] for part in ET.fromstring(text).iter(tag)]


def test_content_is_repeated_as_often_as_is_said_and_numbered() -> None:
    made = expanded(ARMS, {"arms": 2.0, "links": 3.0, "length": 1.0, "armour": 1.0})
    assert names(made, "body") == ["hub", "arm_0", "arm_1"]
    assert names(made, "geom") == ["geom_0_0", "geom_0_1", "geom_1_0", "geom_1_1"]
    assert 'pos="{1/arms} 0 {length}"' in made, "other placeholders stay"
    assert 'size="{armour*1}"' in made, "part of another name is no index"
    assert not repeats(made)


def test_a_count_of_nothing_leaves_the_content_out() -> None:
    assert names(expanded(ARMS, {"arms": 2.0, "links": 1.0}), "geom") == []
    assert names(expanded(ARMS, {"arms": 0.0, "links": 1.0}), "body") == ["hub"]


def test_a_template_without_repeats_is_left_as_it_is() -> None:
    assert expanded("<a  b='1'/>", {}) == "<a  b='1'/>"


def test_what_a_repeat_needs_is_known_and_what_is_too_much_is_refused() -> None:
    assert indices(ARMS) == {"arm", "link"}
    with pytest.raises(KeyError, match="arms"):
        expanded(ARMS, {"links": 1.0})
    with pytest.raises(InvalidMorphology, match=f"at most {MOST}"):
        expanded(ARMS, {"arms": 1e6, "links": 1.0})
