"""The meaning of a robot's state variables: which numbers of the simulation a reward can read.

They follow from the task's MJCF template: its joints and motors, in MuJoCo's order. So a robot of a
third party gets the reward terms that fit it, too.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from robomore.tasks.portable import ENVIRONMENT
from robomore.tasks.repeats import repeats
from robomore.tasks.task import Task, with_counts

_SIZES = {"free": (7, 6), "ball": (4, 3), "slide": (1, 1), "hinge": (1, 1)}
"""Numbers that a joint adds to `qpos` and to `qvel`."""


@dataclass(frozen=True, slots=True)
class RobotSemantics:
    """Python expressions within `_get_rew` for the quantities of one robot.

    Attributes:
        expressions: the quantities that this robot has, by name. An empty expression is a plain
            fact. `height` of the torso and its `rest` value, `lift` (vertical speed), `up` (1 when
            upright), `tip` (forward pitch rate), `roll_free` (the robot may roll over), `spin`
            (squared turning rate), `sideways` (speed across the course), `offset` (distance from
            the course), `heading` (1 when facing along the course), `contacts` (forces), `rates`
            and `angles` of the driven joints in the motors' order, `legs1`, `legs2`, `legs4` or
            `chain` with the joints of a gait, `falls` (an episode ends when the robot is
            unhealthy).
        jumps: whether the task asks for height and not for distance.
    """

    expressions: Mapping[str, str]
    jumps: bool


@dataclass(frozen=True, slots=True)
class _Joint:
    name: str
    kind: str
    axis: str
    position: int
    velocity: int

    @property
    def angle(self) -> str:
        return f"self.data.qpos[{self.position}]"

    @property
    def rate(self) -> str:
        return f"self.data.qvel[{self.velocity}]"


def robot_semantics(task: Task) -> RobotSemantics:
    """Return what a reward can read on the robot of `task`."""
    structured = repeats(task.template)
    if structured:
        counts = [one.reference for one in task.parameters if one.whole]
        task = with_counts(task, counts)
    world = ET.fromstring(task.template).find("worldbody")
    torso = None if world is None else world.find("body")
    if torso is None:
        return RobotSemantics({}, task.goal.motion == "upward")
    joints = _numbered(torso)
    own = [joint for joint in joints if joint.name in _names(torso.findall("joint"))]
    # The axes of a root that is turned are not those of the world.
    turned = torso.get("quat", "1 0 0 0").split() != ["1", "0", "0", "0"]
    sliding = any(joint.kind == "slide" for joint in own)
    found = {} if turned and sliding else _of_root(own)
    driven = _driven(task, joints)
    if driven and not structured:
        found["rates"] = _indexed("self.data.qvel", [joint.velocity for joint in driven])
        found["angles"] = _indexed("self.data.qpos", [joint.position for joint in driven])
    if structured:
        # Only what holds for any number of parts.
        if driven and driven == joints[len(own) :]:
            found["rates"] = f"self.data.qvel[{driven[0].velocity}:]"
            found["angles"] = f"self.data.qpos[{driven[0].position}:]"
        driven = []
    moved = {joint.name for joint in driven}
    legs = [
        [joint for joint in joints if joint.name in _names(_joints(child)) & moved]
        for child in torso.findall("body")
    ]
    found |= _of_legs([leg for leg in legs if leg], found)
    if task.terrain is not None:
        # On uneven ground the height of the torso says nothing.
        found = {name: text for name, text in found.items() if name not in ("height", "rest")}
    options = task.options(dict(zip(task.names, task.reference, strict=True)))
    upright = tuple(options.get("upright", ()))
    if task.environment == ENVIRONMENT and upright not in ((), (1.0, 0.0, 0.0, 0.0)):
        # The axes of its root are not those of the world at rest.
        known = {"up": "np.cos(self.tilt)", "heading": "np.cos(self.heading)"}
        found |= {name: text for name, text in known.items() if name in found}
        found.pop("tip", None)
    if any(name.startswith("healthy_") for name in options):
        found["falls"] = "self.is_healthy"
    elif "tip" in found:
        found["roll_free"] = ""
    return RobotSemantics(found, task.goal.motion == "upward")


def _of_root(joints: Sequence[_Joint]) -> dict[str, str]:
    """Return the quantities that follow from the torso's own joints."""
    kinds = [joint.kind for joint in joints]
    if kinds == ["free"]:
        return {
            "height": "self.data.qpos[2]",
            "rest": "self.init_qpos[2]",
            "lift": "self.data.qvel[2]",
            # Rotation matrix of the torso's quaternion (w, x, y, z) at qpos[3:7].
            "up": "1 - 2 * (self.data.qpos[4] ** 2 + self.data.qpos[5] ** 2)",
            "heading": "1 - 2 * (self.data.qpos[5] ** 2 + self.data.qpos[6] ** 2)",
            "spin": "np.sum(np.square(self.data.qvel[3:6]))",
            "tip": "self.data.qvel[4]",
            "roll_free": "",
            "sideways": "self.data.qvel[1]",
            "offset": "self.data.qpos[1]",
            "contacts": "self.data.cfrc_ext",
        }
    if sorted(kinds) != ["hinge", "slide", "slide"]:
        return {}
    (turn,) = (joint for joint in joints if joint.kind == "hinge")
    slides = {joint.axis: joint for joint in joints if joint.kind == "slide"}
    if slides.pop("1 0 0", None) is None or len(slides) != 1:
        return {}
    ((axis, across),) = slides.items()
    if axis == "0 0 1":
        return {
            "height": across.angle,
            "rest": f"self.init_qpos[{across.position}]",
            "lift": across.rate,
            "up": f"np.cos({turn.angle})",
            "spin": f"{turn.rate} ** 2",
            "tip": turn.rate,
        }
    return {
        "sideways": across.rate,
        "offset": across.angle,
        "heading": f"np.cos({turn.angle})",
        "spin": f"{turn.rate} ** 2",
    }


def _of_legs(legs: Sequence[Sequence[_Joint]], found: Mapping[str, str]) -> dict[str, str]:
    """Return the quantities of the joints that make a gait."""
    if len(legs) == 2 and "lift" in found:
        (one, *_), (other, *_) = legs
        return {
            "legs2": "",
            "hip_rate": one.rate,
            "other_hip_rate": other.rate,
            "hip_angle": one.angle,
            "other_hip_angle": other.angle,
        }
    if len(legs) == 4 and "roll_free" in found:
        # The legs are counted around the torso, so the first and the third are a diagonal. Seen
        # from above, a left leg swings forward clockwise and a right leg counter-clockwise.
        return {"legs4": "", **{f"hip{i}": leg[0].rate for i, leg in enumerate(legs, 1)}}
    if len(legs) == 1 and "lift" in found and len(legs[0]) >= 2:
        return {"legs1": "", "knee_rate": legs[0][1].rate, "knee_angle": legs[0][1].angle}
    if len(legs) == 1 and len(legs[0]) >= 2:
        first, second, *_ = legs[0]
        return {
            "chain": "",
            "bend": first.angle,
            "next_bend": second.angle,
            "bend_rate": first.rate,
            "next_bend_rate": second.rate,
        }
    return {}


def _numbered(torso: ET.Element) -> list[_Joint]:
    """Return all joints in MuJoCo's order: a body's own joints before those of its children."""
    joints: list[_Joint] = []
    for joint in _joints(torso):
        kind = joint.get("type", "hinge")
        last = joints[-1] if joints else None
        position = last.position + _SIZES[last.kind][0] if last else 0
        velocity = last.velocity + _SIZES[last.kind][1] if last else 0
        joints.append(
            _Joint(joint.get("name", ""), kind, joint.get("axis", "0 0 1"), position, velocity)
        )
    return joints


def _joints(body: ET.Element) -> Iterator[ET.Element]:
    yield from body.findall("joint")
    for child in body.findall("body"):
        yield from _joints(child)


def _driven(task: Task, joints: Sequence[_Joint]) -> list[_Joint]:
    """Return the joint of each motor, in the motors' order, which is that of the action."""
    by_name = {joint.name: joint for joint in joints}
    motors = ET.fromstring(task.template).findall("actuator/*")
    found = [by_name[name] for motor in motors if (name := motor.get("joint", "")) in by_name]
    return found if len(found) == len(motors) else []


def _names(joints: Iterable[ET.Element]) -> set[str]:
    return {joint.get("name", "") for joint in joints}


def _indexed(array: str, indices: Sequence[int]) -> str:
    """Return `array[3:9]` for consecutive indices, and `array[[12, 13, 6]]` for others."""
    if list(indices) == list(range(indices[0], indices[0] + len(indices))):
        return f"{array}[{indices[0]}:{indices[0] + len(indices)}]"
    return f"{array}[{list(indices)}]"
