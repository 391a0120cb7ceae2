"""Which pairs of parts must not overlap, and when they do."""

from __future__ import annotations

import mujoco
import pytest

from robomore.audit.overlap import Overlap
from robomore.audit.parts import may_collide
from robomore.envs.compile import compile_model
from robomore.tasks import get_task

TWO_LEGS = """<mujoco><worldbody>
<geom name="floor" type="plane" size="1 1 1"/>
<body name="trunk" pos="0 0 1"><freejoint/><geom name="trunk" type="box" size=".2 .1 .05"/>
 <body name="left" pos="0 .1 0"><joint axis="0 1 0"/>
  <geom name="left" type="capsule" fromto="0 0 -.1 0 0 -.4" size=".02"/></body>
 <body name="right" pos="0 -.1 0"><joint axis="0 1 0"/>
  <geom name="right" type="capsule" fromto="0 0 -.1 0 0 -.4" size=".02"/></body>
</body></worldbody><contact>{contact}</contact></mujoco>"""

LEG = 'type="capsule" fromto="0 0 -.1 0 0 -.4" size=".02"'


def looked_at(model: mujoco.MjModel, **angles: float) -> Overlap:
    data, overlap = mujoco.MjData(model), Overlap(model)
    for joint, angle in angles.items():
        data.qpos[model.joint(joint).qposadr[0]] = angle
    mujoco.mj_forward(model, data)
    for _ in range(8):
        overlap.look(data)
    return overlap


def test_legs_that_overlap_at_the_start_count_but_not_their_common_hip() -> None:
    task = get_task("walker")
    model = compile_model(task, task.reference)
    together = looked_at(model)
    assert together.share == 1 and set(together.worst) != {"thigh_geom", "thigh_left_geom"}
    assert looked_at(model, thigh_joint=-0.5, thigh_left_joint=0.5).share == 0


@pytest.mark.parametrize(
    ("contact", "off"),
    [
        ("", False),
        ('<exclude body1="right" body2="left"/>', True),
        ('<exclude body1="right" body2="left"/><pair geom1="left" geom2="right"/>', False),
    ],
)
def test_what_a_contact_element_says_counts(contact: str, off: bool) -> None:
    model = mujoco.MjModel.from_xml_string(TWO_LEGS.format(contact=contact))
    left, right = model.geom("left").id, model.geom("right").id
    assert Overlap(model).is_off == off
    assert may_collide(model, right, left) == (not off)
    # MuJoCo says the same.
    model.geom_pos[right] = model.geom_pos[left] + [0.0, 0.19, 0.0]
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert any(set(pair) == {left, right} for pair in data.contact.geom.tolist()) == (not off)


@pytest.mark.parametrize(("apart", "share"), [(0.06, 1), (0.08, 0)])
def test_the_depth_is_told_in_the_thinnest_half_side_of_a_box(apart: float, share: float) -> None:
    """Two plates, each 10 cm thick and 40 cm wide, lie in each other by 4 cm and by 2 cm."""
    plates = TWO_LEGS.format(contact='<exclude body1="right" body2="left"/>')
    for height in (-0.5, -0.5 - apart):
        plates = plates.replace(LEG, f'type="box" pos="0 0 {height}" size=".2 .2 .05"', 1)
    assert looked_at(mujoco.MjModel.from_xml_string(plates)).share == share
