"""Walker: a robot with two equal legs in a vertical plane; Hopper's dimensions, each leg twice."""

from __future__ import annotations

from robomore.tasks import hopper
from robomore.tasks.task import Task
from robomore.tasks.template import read_asset

WALKER = Task(
    id="walker",
    title="Walker",
    description=(
        "The walker is a two-legged robot that moves in a vertical plane. It has a torso at the "
        "top and two equal legs below it, each of a thigh, a leg and a foot; the two feet carry "
        "the whole body. Six motors turn the six hinges: hip, knee and ankle of each leg. The "
        "goal is to walk forward, in the direction of +x (to the right), by choosing the torques "
        "on the six hinges."
    ),
    fitness="distance",
    template=read_asset("walker.xml"),
    parameters=hopper.parameters(foot_back=0.0, foot_front=0.2, foot_note=", in both legs"),
    rules=hopper.RULES,
    search_rules=hopper.STANDING_RULES,
    version=2,
    reward=hopper.REWARD,
    environment="robomore.envs.robots.walker:WalkerEnvironment",
    options=hopper.health,
)
