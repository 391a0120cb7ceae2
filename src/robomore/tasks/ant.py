"""Ant: a four-legged robot in three dimensions, and its variants.

Ant-Powered, Ant-Desert and Ant-Jump replace single fields of Ant; they are no robots of their own.
"""

from __future__ import annotations

import math
from dataclasses import replace

from robomore.tasks.geometry import LEAST_LENGTH
from robomore.tasks.task import Parameter, Rule, Task, Values
from robomore.tasks.template import read_asset
from robomore.tasks.terrain import DESERT, on_terrain

START_CLEARANCE = 0.15
"""The torso starts this much higher than a leg's last segment is long, in m (see template)."""

RESET_NOISE = 0.1
"""A reset moves the torso up or down by as much, in m."""

LOWEST_TORSO = 0.1
"""Ant counts as fallen when its torso is lower than this, in m."""

HIGHEST_TORSO = 2.3
"""Ant counts as out of control when its torso is higher than this, in m."""

LEAST_SHARE = 0.3
"""The first and third segment that samplers draw are at least this fraction of the second one.

Where the second one dwarfs both, its motor whirls a robot that weighs almost nothing elsewhere, up
to rates that the fixed time step cannot follow. Of 973 thin random robots of Ant-Powered, driven by
random full torques for 25 s and never reset, 58 diverged: one in seven of those outside this limit
and none of the 575 within it. Rare cases remain, thrown far above any healthy height before.
"""

ANT_REWARD = '''def _get_rew(self, x_velocity, action):
    """Forward speed and a bonus for staying healthy, less the cost of effort and of contacts."""
    forward = self._forward_reward_weight * x_velocity
    healthy = self.healthy_reward
    effort = self.control_cost(action)
    contact = self.contact_cost
    reward = (forward + healthy) - (effort + contact)
    terms = {"forward": forward, "healthy": healthy, "effort": -effort, "contact": -contact}
    return reward, terms
'''

JUMP_REWARD = '''def _get_rew(self, x_velocity, action):
    """Upward speed and a bonus for staying healthy, less the cost of effort and of contacts."""
    upward = self._forward_reward_weight * self.data.qvel[2]
    healthy = self.healthy_reward
    effort = self.control_cost(action)
    contact = self.contact_cost
    reward = (upward + healthy) - (effort + contact)
    terms = {"upward": upward, "healthy": healthy, "effort": -effort, "contact": -contact}
    return reward, terms
'''


def start_height(values: Values) -> float:
    """Return the torso's height when an episode starts, in m, before reset noise."""
    return _length(values, "foot") + START_CLEARANCE


def _length(values: Values, part: str) -> float:
    return math.hypot(values[f"{part}_x"], values[f"{part}_y"])


def _starts_too_low(values: Values) -> str | None:
    height = start_height(values)
    least = LOWEST_TORSO + RESET_NOISE
    if height >= least:
        return None
    return (
        f"foot_x = {values['foot_x']:g} m and foot_y = {values['foot_y']:g} m start the torso at "
        f"{height:.4g} m, below {least:g} m, where it counts as fallen"
    )


def _starts_in_ground(values: Values) -> str | None:
    most = start_height(values) - RESET_NOISE
    radii = ("torso_radius", "hip_radius", "leg_radius", "foot_radius")
    deep = [f"{name} = {values[name]:g} m" for name in radii if values[name] > most]
    if not deep:
        return None
    return (
        f"{' and '.join(deep)} reaches into the ground at the start; with this foot segment a "
        f"radius may be at most {most:.4g} m"
    )


def _out_of_proportion(values: Values) -> str | None:
    least = LEAST_SHARE * _length(values, "leg")
    short = [
        f"{part}_x = {values[f'{part}_x']:g} m and {part}_y = {values[f'{part}_y']:g} m make a "
        f"{part} segment of {_length(values, part):.4g} m"
        for part in ("hip", "foot")
        if _length(values, part) < least
    ]
    if not short:
        return None
    return (
        f"{' and '.join(short)}; with leg_x = {values['leg_x']:g} m and leg_y = "
        f"{values['leg_y']:g} m it must be at least {least:.4g} m long"
    )


def _no_length(values: Values) -> str | None:
    none = [
        f"{part}_x = {values[f'{part}_x']:g} m and {part}_y = {values[f'{part}_y']:g} m make a "
        f"{part} segment without any length"
        for part in ("hip", "leg", "foot")
        if _length(values, part) < LEAST_LENGTH
    ]
    return "; ".join(none) or None


def _position(name: str, reference: float, high: float, meaning: str) -> Parameter:
    return Parameter(name, -3.0, 3.0, reference, meaning, scale="log", search=(0.01, high))


def _radius(name: str, reference: float, high: float, meaning: str) -> Parameter:
    return Parameter(name, 0.005, 1.0, reference, meaning, scale="log", search=(0.005, high))


ANT = Task(
    id="ant",
    title="Ant",
    description=(
        "The ant is a robot in three dimensions: a ball-shaped torso that moves and turns freely, "
        "and four legs around it. Each leg sticks out from the torso's centre with a fixed "
        "segment, followed by two moving segments. Eight motors turn the eight hinges: a hip "
        "about the vertical axis and an ankle about a horizontal axis in each leg. The goal is to "
        "coordinate the four legs so that the robot moves forward, in the direction of +x (to the "
        "right), by choosing the torques on the eight hinges."
    ),
    fitness="distance",
    template=read_asset("ant.xml"),
    parameters=(
        _radius("torso_radius", 0.25, 0.5, "radius of the torso's ball"),
        _position("hip_x", 0.2, 2.0, "x from the torso's centre to the hip (first, fixed segment)"),
        _position("hip_y", 0.2, 2.0, "y from the torso's centre to the hip (first, fixed segment)"),
        _position("leg_x", 0.2, 2.0, "x from the hip to the ankle (second segment)"),
        _position("leg_y", 0.2, 2.0, "y from the hip to the ankle (second segment)"),
        # A longer one would start higher than the healthy range of Ant allows.
        _position("foot_x", 0.4, 1.4, "x from the ankle to the leg's tip (third segment)"),
        _position("foot_y", 0.4, 1.4, "y from the ankle to the leg's tip (third segment)"),
        _radius("hip_radius", 0.08, 0.25, "radius of each leg's first, fixed segment"),
        _radius("leg_radius", 0.08, 0.25, "radius of each leg's second segment"),
        _radius("foot_radius", 0.08, 0.25, "radius of each leg's third segment"),
    ),
    rules=(Rule("each segment of a leg must have a length", _no_length),),
    search_rules=(
        Rule(
            f"the torso starts at least {LOWEST_TORSO + RESET_NOISE:g} m above the ground: "
            f"sqrt(foot_x^2 + foot_y^2) + {START_CLEARANCE:g} >= {LOWEST_TORSO + RESET_NOISE:g}",
            _starts_too_low,
        ),
        Rule(
            "no part reaches into the ground at the start: each radius <= "
            f"sqrt(foot_x^2 + foot_y^2) + {START_CLEARANCE - RESET_NOISE:g}",
            _starts_in_ground,
        ),
        Rule(
            "the first and third segment of a leg are each at least "
            f"{LEAST_SHARE:g} times as long as the second: sqrt(hip_x^2 + hip_y^2) and "
            f"sqrt(foot_x^2 + foot_y^2) >= {LEAST_SHARE:g} * sqrt(leg_x^2 + leg_y^2)",
            _out_of_proportion,
        ),
    ),
    version=2,
    reward=ANT_REWARD,
    environment="robomore.envs.robots.ant:AntEnvironment",
    options=lambda values: {"healthy_z_range": (LOWEST_TORSO, HIGHEST_TORSO)},
    constants={"gear": 150.0},
)

ANT_POWERED = replace(
    ANT,
    id="ant-powered",
    title="Ant-Powered",
    description=ANT.description + " Its motors have twice the usual torque.",
    options=lambda values: {"healthy_z_range": (0.0, 10.0)},
    constants={"gear": 300.0},
)

ANT_DESERT = replace(
    ANT,
    id="ant-desert",
    title="Ant-Desert",
    description=ANT.description
    + (
        " The ground is a desert: dunes of loose sand up to 1.5 m high, with little friction. "
        "Heights are measured from the ground's lowest level, so the torso's height also follows "
        "the dunes."
    ),
    template=on_terrain(ANT.template, DESERT),
    # The ground itself rises and falls, so a torso's height says little about its health.
    options=lambda values: {"healthy_z_range": (-10.0, 10.0)},
    terrain=DESERT,
)

ANT_JUMP = replace(
    ANT,
    id="ant-jump",
    title="Ant-Jump",
    description=ANT.description.replace(
        "so that the robot moves forward, in the direction of +x (to the right),",
        "so that the robot jumps straight up, its torso as high above the ground as it can,",
    ),
    fitness="height",
    reward=JUMP_REWARD,
    options=lambda values: {"healthy_z_range": (0.0, 100.0)},
)
