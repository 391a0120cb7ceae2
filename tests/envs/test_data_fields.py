"""Whatever a reward reads of MuJoCo's data is what plain MuJoCo gives, or it is refused."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
import pytest

from robomore.envs.data_fields import ON_REQUEST, READABLE, REFUSED, REQUESTS
from robomore.envs.read_only import read_only_data
from robomore.envs.vector_env import VectorEnv
from robomore.tasks import get_task

PUBLIC = [name for name in dir(mujoco.MjData) if not name.startswith("_")]
FINDERS = ("actuator", "body", "cam", "camera", "geom", "jnt", "joint", "light", "sensor", "site")
FINDERS += ("ten", "tendon")
NUMBERS = READABLE - {*FINDERS, "model", "contact"}

RICH = """
<mujoco>
  <option integrator="implicitfast"><flag energy="enable"/></option>
  <worldbody>
    <geom name="ground" type="plane" size="5 5 .1"/>
    <camera name="eye" pos="0 0 3"/><light name="sun" pos="0 0 4"/>
    <body name="target" mocap="true" pos="1 0 1"><geom size=".02" contype="0"/></body>
    <body name="ball" pos="0 0 .19"><freejoint/><geom size=".2"/><site name="mark" pos=".1 0 0"/>
      <body name="arm" pos="0 0 .3"><joint name="hinge" axis="0 1 0" stiffness="2" damping=".1"/>
        <geom type="capsule" size=".05 .2"/><site name="end" pos="0 0 .2"/></body></body>
  </worldbody>
  <tendon><spatial name="rope"><site site="mark"/><site site="end"/></spatial></tendon>
  <actuator>
    <general name="motor" joint="hinge" dyntype="filter" dynprm=".1" gainprm="3"/>
  </actuator>
  <sensor><subtreelinvel body="ball"/><accelerometer site="end"/><force site="end"/></sensor>
</mujoco>
"""
"""A model that has something in fields that our robots leave empty."""


def test_every_field_is_readable_or_refused() -> None:
    assert set(PUBLIC) == READABLE | REFUSED
    assert set(ON_REQUEST) < READABLE
    assert {"energy", "qfrc_inverse", "maxuse_stack", "timer", "warning"} < REFUSED


def everything(model: mujoco.MjModel, data: Any) -> Iterator[tuple[str, Any]]:
    """Yield all that can be read of an `MjData`, or of what a reward sees of it."""
    for name in sorted(NUMBERS):
        yield name, getattr(data, name)
    for field in ("dist", "pos", "frame", "friction", "geom", "dim", "efc_address", "solref"):
        yield f"contact.{field}", getattr(data.contact, field)
    for finder in FINDERS:
        kind = {"cam": "camera", "jnt": "joint", "ten": "tendon"}.get(finder, finder)
        count = {"joint": "njnt", "camera": "ncam", "actuator": "nu"}.get(kind, f"n{kind}")
        for index in range(getattr(model, count)):
            part = getattr(data, finder)(index)
            for name in dir(part):
                if not name.startswith("_") and name not in REFUSED:
                    yield f"{finder}({index}).{name}", getattr(part, name)


def compare(model: mujoco.MjModel, seen: list[tuple[str, Any]], plain: mujoco.MjData) -> None:
    """Hold what a reward saw against plain MuJoCo with everything computed."""
    mujoco.mj_rnePostConstraint(model, plain)
    mujoco.mj_subtreeVel(model, plain)
    expected = dict(everything(model, plain))
    assert [name for name, _ in seen] == list(expected)
    different = [name for name, value in seen if not same(value, expected[name])]
    assert different == []


def same(one: Any, other: Any) -> bool:
    return np.array_equal(np.asarray(one), np.asarray(other))


@pytest.mark.parametrize("task", ["ant", "half-cheetah", "swimmer", "walker"])
def test_a_reward_reads_what_plain_mujoco_gives(task: str) -> None:
    """From the first look on, whenever that is, and after a checkpoint."""
    known, seen = get_task(task), []

    def reward(self: Any, x_velocity: float, action: Any) -> tuple[float, dict[str, float]]:
        if not len(seen) and self.data.time > 0.2:
            found = everything(self.model, self.data)
            seen.extend((name, np.array(value)) for name, value in found)
        return 0.0, {}

    env = VectorEnv(known, known.reference, 1, reward)
    env.reset(1)
    random, looks = np.random.default_rng(0), 0
    plain = mujoco.MjData(env.model)
    physics = mujoco.mjtState.mjSTATE_INTEGRATION
    for _ in range(40):
        if looks == 1 and not seen:
            saved, env = env.state(), VectorEnv(known, known.reference, 1, reward)
            env.restore(saved)
        state = np.empty(mujoco.mj_stateSize(env.model, physics))
        mujoco.mj_getState(env.model, env.data[0], state, physics)
        action = random.uniform(-1, 1, (1, env.action_size))
        env.step(action)
        if seen:
            mujoco.mj_setState(env.model, plain, state, physics)
            plain.ctrl[:] = action[0]
            mujoco.mj_step(env.model, plain, env.environment.frame_skip)
            compare(env.model, seen, plain)
            looks += 1
            seen.clear()
    assert looks > 5


def test_so_it_is_in_a_model_with_everything_in_it() -> None:
    model = mujoco.MjModel.from_xml_string(RICH)
    live, plain = mujoco.MjData(model), mujoco.MjData(model)
    requested: set[int] = set()

    def on_request(place: int) -> None:
        requested.add(place)
        REQUESTS[place](model, live)

    view = read_only_data(live, on_request)
    for _ in range(60):
        for data in (live, plain):
            data.ctrl[:] = 0.5
            mujoco.mj_step(model, data)
        for place in requested:
            REQUESTS[place](model, live)
        compare(model, list(everything(model, view)), plain)
    assert requested == {0, 1} and live.ncon and live.sensordata.any() and live.ten_velocity.any()


@pytest.mark.parametrize("name", sorted(REFUSED))
def test_what_is_refused_says_why(name: str) -> None:
    model = mujoco.MjModel.from_xml_string(RICH)
    view = read_only_data(mujoco.MjData(model), lambda place: None)
    with pytest.raises(AttributeError, match=f"a reward cannot read `{name}` of the simulation: "):
        getattr(view, name)
    joint = view.joint("hinge")
    if name in dir(joint):
        with pytest.raises(AttributeError, match="a reward cannot read"):
            getattr(joint, name)
