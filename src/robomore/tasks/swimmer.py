"""Swimmer: a chain of three links in a plane, immersed in a viscous fluid."""

from __future__ import annotations

from robomore.tasks.geometry import Capsule, Shape
from robomore.tasks.task import Parameter, Task, Values
from robomore.tasks.template import read_asset

LINKS = ("front", "middle", "back")

SPEED_REWARD = '''def _get_rew(self, x_velocity, action):
    """Forward speed less the cost of effort."""
    forward = self._forward_reward_weight * x_velocity
    effort = self.control_cost(action)
    reward = forward - effort
    terms = {"forward": forward, "effort": -effort}
    return reward, terms
'''


def _shapes(values: Values) -> tuple[Shape, ...]:
    return tuple(Capsule(values[f"{link}_radius"], values[f"{link}_length"]) for link in LINKS)


def _length(link: str) -> Parameter:
    meaning = f"length of the {link} link between the centres of its ends"
    return Parameter(f"{link}_length", 0.05, 3.0, 1.0, meaning, scale="log")


def _radius(link: str) -> Parameter:
    return Parameter(f"{link}_radius", 0.005, 0.3, 0.1, f"radius of the {link} link", scale="log")


SWIMMER = Task(
    id="swimmer",
    title="Swimmer",
    description=(
        "The swimmer is a chain of three links that moves in a horizontal plane, immersed in a "
        "fluid that resists every motion. Two motors turn the two hinges between the links. It "
        "always starts stretched out along x, up to a small random deviation. The goal is to swim "
        "forward, in the direction of +x (to the right), by choosing the torques on the two "
        "hinges and pushing against the fluid."
    ),
    fitness="distance",
    template=read_asset("swimmer.xml"),
    parameters=(*map(_length, LINKS), *map(_radius, LINKS)),
    shapes=_shapes,
    reward=SPEED_REWARD,
    environment="robomore.tasks.environments.swimmer:SwimmerEnvironment",
)
