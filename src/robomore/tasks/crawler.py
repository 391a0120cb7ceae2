"""Crawler: a ball on legs, whose number and whose numbers of segments are free as well.

It is no task of the paper. It shows how a task leaves the structure of a robot to the search.
"""

from __future__ import annotations

import math
from typing import Any

from robomore.tasks.task import Parameter, Task, Values
from robomore.tasks.template import read_asset

SEGMENTS = ("upper", "middle", "lower")

REWARD = '''def _get_rew(self, x_velocity, action):
    """Forward speed and a bonus for not falling, less effort and drift."""
    forward = x_velocity
    healthy = 0.1
    effort = 0.02 * np.sum(np.square(action))
    drift = 0.1 * abs(self.data.qvel[1])
    reward = forward + healthy - effort - drift
    terms = {"forward": forward, "healthy": healthy, "effort": -effort, "drift": -drift}
    return reward, terms
'''


def _options(values: Values) -> dict[str, Any]:
    return {
        "frame_skip": 8,
        "home": {},
        "upright": (1.0, 0.0, 0.0, 0.0),
        "healthy_tilt": 1.2,
        "healthy_height": (0.3, 3.0),
    }


def _length(segment: str, reference: float) -> Parameter:
    meaning = f"length of the {segment} segment of each leg, if the legs have one"
    return Parameter(f"{segment}_length", 0.05, 0.8, reference, meaning, scale="log")


def _radius(segment: str, reference: float) -> Parameter:
    meaning = f"radius of the {segment} segment of each leg, if the legs have one"
    return Parameter(f"{segment}_radius", 0.008, 0.1, reference, meaning, scale="log")


CRAWLER = Task(
    id="crawler",
    title="Crawler",
    description=(
        "The crawler is a ball that carries legs, all alike and evenly spread around it. How many "
        "legs there are (`legs`) and of how many segments each one consists (`segments`) is part "
        "of the design. The hinge of the first segment turns it about the vertical, by 40 degrees "
        "to either side; those of the next ones bend the leg up and down by as much. One motor "
        "drives each hinge. At rest a leg of one segment points down and outwards; with more "
        "segments the first one is level or rises and the last one points down. The goal is to "
        "run forward, in the direction of +x, by choosing the torques on the hinges. An episode "
        "ends when the ball tilts by more than 69 degrees or sinks below 0.3 of its height."
    ),
    fitness="distance",
    template=read_asset("crawler.xml"),
    parameters=(
        Parameter("legs", 3, 8, 4, "number of legs", unit="", whole=True),
        Parameter("segments", 1, 3, 2, "number of segments of each leg", unit="", whole=True),
        Parameter("torso_radius", 0.04, 0.4, 0.15, "radius of the ball", scale="log"),
        _length("upper", 0.25),
        _length("middle", 0.3),
        _length("lower", 0.2),
        _radius("upper", 0.04),
        _radius("middle", 0.03),
        _radius("lower", 0.025),
    ),
    constants={"pi": math.pi, "gear": 20.0},
    reward=REWARD,
    environment="robomore.envs.robots.own_robot:OwnRobotEnvironment",
    options=_options,
    mass="Mass follows from the volume, at 200 kg/m³.",
)
