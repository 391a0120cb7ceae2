"""Hopper: a one-legged robot in a vertical plane."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

from robomore.tasks.geometry import LEAST_LENGTH
from robomore.tasks.task import Parameter, Rule, Task, Values
from robomore.tasks.template import read_asset

LEAST_SEGMENT = 0.05
"""Shortest torso, thigh and leg that samplers draw, in m."""

LEAST_FOOT = 0.02
"""Shortest foot between the centres of its ends that samplers draw, in m."""

LOWEST_TORSO = 0.56
"""The robot counts as fallen below this fraction of its torso's height at rest: 0.7 m for the
official robot, as in Gymnasium, and in proportion for smaller and larger ones."""

LARGEST_ANGLE = 2.0
"""The robot counts as fallen when its torso leans further than this, in rad."""

REWARD = '''def _get_rew(self, x_velocity, action):
    """Forward speed and a bonus for staying healthy, less the cost of effort."""
    forward = self._forward_reward_weight * x_velocity
    healthy = self.healthy_reward
    effort = self.control_cost(action)
    reward = forward + healthy - effort
    terms = {"forward": forward, "healthy": healthy, "effort": -effort}
    return reward, terms
'''

LOWEST_POINTS = {
    "torso_radius": "hip_height",
    "thigh_radius": "knee_height",
    "leg_radius": "ankle_height",
    "foot_radius": "ankle_height",
}
"""Each part's radius, and the height of its lower end."""

HEIGHTS = ("torso_top", "hip_height", "knee_height", "ankle_height")


def rest_height(values: Values) -> float:
    """Return the height of the torso's middle when the robot stands upright, in m."""
    return (values["torso_top"] + values["hip_height"]) / 2


def parameters(foot_back: float, foot_front: float, foot_note: str = "") -> tuple[Parameter, ...]:
    """Return the free dimensions of Hopper and Walker, which differ in the official foot alone."""

    def height(name: str, low: float, high: float, reference: float, meaning: str) -> Parameter:
        meaning += ", standing upright"
        return Parameter(name, 0.0, 5.0, reference, meaning, scale="log", search=(low, high))

    def foot(end: str, low: float, high: float, reference: float) -> Parameter:
        # Either end may come first, and both may lie on one side of the ankle.
        meaning = f"x of the foot's {end} end from the ankle"
        return Parameter(f"foot_{end}", -3.0, 3.0, reference, meaning, search=(low, high))

    def radius(name: str, reference: float, meaning: str) -> Parameter:
        meaning = f"radius of {meaning}"
        return Parameter(name, 0.005, 1.0, reference, meaning, scale="log", search=(0.005, 0.25))

    return (
        height("torso_top", 0.17, 3.0, 1.45, "height of the torso's upper end above the ground"),
        height("hip_height", 0.12, 2.9, 1.05, "height of the torso's lower end, the hip"),
        height("knee_height", 0.06, 2.5, 0.6, "height of the knee"),
        height("ankle_height", 0.005, 2.0, 0.1, "height of the ankle and of the foot's axis"),
        foot("back", -1.0, 0.0, foot_back),
        foot("front", 0.0, 1.0, foot_front),
        radius("torso_radius", 0.05, "the torso"),
        radius("thigh_radius", 0.05, "the thigh" + foot_note),
        radius("leg_radius", 0.04, "the leg below the knee" + foot_note),
        radius("foot_radius", 0.06, "the foot" + foot_note),
    )


def _out_of_order(least: float) -> Callable[[Values], str | None]:
    def violation(values: Values) -> str | None:
        wrong = [
            f"{upper} = {values[upper]:g} m is not at least {least:g} m above "
            f"{lower} = {values[lower]:g} m"
            for upper, lower in pairwise(HEIGHTS)
            if values[upper] - values[lower] < least
        ]
        return "; ".join(wrong) or None

    return violation


def _no_foot(values: Values) -> str | None:
    if abs(values["foot_front"] - values["foot_back"]) >= LEAST_LENGTH:
        return None
    return (
        f"foot_back = {values['foot_back']:g} m and foot_front = {values['foot_front']:g} m are "
        "the same point"
    )


def _foot_too_short(values: Values) -> str | None:
    length = values["foot_front"] - values["foot_back"]
    if length >= LEAST_FOOT:
        return None
    return (
        f"foot_back = {values['foot_back']:g} m and foot_front = {values['foot_front']:g} m make "
        f"a foot of {length:.4g} m, shorter than {LEAST_FOOT:g} m"
    )


def _starts_in_ground(values: Values) -> str | None:
    deep = [
        f"{radius} = {values[radius]:g} m is more than {height} = {values[height]:g} m"
        for radius, height in LOWEST_POINTS.items()
        if values[radius] > values[height]
    ]
    return f"{'; '.join(deep)}, which reaches into the ground at the start" if deep else None


def _overlap(values: Values) -> str | None:
    faults = []
    for length, (upper, lower), radii in (
        (
            values["hip_height"] - values["knee_height"],
            ("hip_height", "knee_height"),
            ("torso_radius", "leg_radius"),
        ),
        (
            values["knee_height"] - values["ankle_height"],
            ("knee_height", "ankle_height"),
            ("thigh_radius", "foot_radius"),
        ),
    ):
        needed = sum(values[name] for name in radii)
        if length < needed:
            faults.append(
                f"{upper} - {lower} = {length:.4g} m is less than {' + '.join(radii)} = "
                f"{needed:.4g} m, so that parts which collide overlap"
            )
    return "; ".join(faults) or None


RULES = (
    # Its volume is defined for a robot that stands on its foot, torso uppermost. Of two equal
    # heights MuJoCo makes no capsule.
    Rule("torso_top > hip_height > knee_height > ankle_height", _out_of_order(LEAST_LENGTH)),
    Rule("foot_front and foot_back must differ", _no_foot),
)
"""What a robot of this family must keep to; Walker shares them.

All else simulates: 30 published Hoppers and Walkers, and random ones with parts inside the ground
or inside one another (docs/differences.md).
"""

STANDING_RULES = (
    Rule(f"torso, thigh and leg at least {LEAST_SEGMENT:g} m long", _out_of_order(LEAST_SEGMENT)),
    Rule(f"foot_front - foot_back >= {LEAST_FOOT:g} m", _foot_too_short),
    Rule(
        "no part reaches into the ground at the start: "
        + ", ".join(f"{radius} <= {height}" for radius, height in LOWEST_POINTS.items()),
        _starts_in_ground,
    ),
)
"""What samplers keep to; Walker shares them."""


def health(values: Values) -> dict[str, Any]:
    """Return the limits beyond which the robot counts as fallen."""
    return {
        "healthy_z_range": (LOWEST_TORSO * rest_height(values), math.inf),
        "healthy_angle_range": (-LARGEST_ANGLE, LARGEST_ANGLE),
    }


HOPPER = Task(
    id="hopper",
    title="Hopper",
    description=(
        "The hopper is a one-legged robot that moves in a vertical plane. It has four parts one "
        "below the other: a torso, a thigh, a leg, and a single foot that carries the whole body. "
        "Three motors turn the three hinges between them: hip, knee and ankle. The goal is to hop "
        "forward, in the direction of +x (to the right), by choosing the torques on the three "
        "hinges."
    ),
    fitness="distance",
    template=read_asset("hopper.xml"),
    parameters=parameters(foot_back=-0.13, foot_front=0.26),
    rules=RULES,
    search_rules=(
        *STANDING_RULES,
        Rule(
            "parts that are no neighbours do not overlap at the start: hip_height - knee_height "
            ">= torso_radius + leg_radius, and knee_height - ankle_height >= thigh_radius + "
            "foot_radius",
            _overlap,
        ),
    ),
    version=2,
    reward=REWARD,
    environment="robomore.envs.robots.hopper:HopperEnvironment",
    options=lambda values: {**health(values), "healthy_state_range": (-100.0, 100.0)},
)
