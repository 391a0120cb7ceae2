"""Swimmer: a chain of three links in a plane, immersed in a viscous fluid."""

from __future__ import annotations

from robomore.tasks.geometry import LEAST_LENGTH
from robomore.tasks.task import Parameter, Rule, Task, Values
from robomore.tasks.template import read_asset

LINKS = ("front", "middle", "back")

THINNEST = 0.01
"""Smallest radius in m that samplers draw, for links long enough."""

THICK_ENOUGH = 0.03
"""Radius in m with which samplers draw links of any length."""

SLENDER = 0.017
"""Radius times shortest length that samplers draw in between, in m^2."""

SPEED_REWARD = '''def _get_rew(self, x_velocity, action):
    """Forward speed less the cost of effort."""
    forward = self._forward_reward_weight * x_velocity
    effort = self.control_cost(action)
    reward = forward - effort
    terms = {"forward": forward, "effort": -effort}
    return reward, terms
'''


def least_radius(shortest: float) -> float:
    """Return the smallest radius in m that samplers draw where the shortest link is `shortest` m.

    The fluid is four times as dense as the links. It stops a light link within a fraction of the
    fixed time step, and the explicit integrator may then throw the link back faster than it came.
    Below this limit some swimmers diverge when every motor changes sign in every control step.
    Others swim (radii of 2 cm went 60 m), so that a short try decides and not this limit.
    """
    return min(THICK_ENOUGH, max(THINNEST, SLENDER / shortest))


def _too_light(values: Values) -> str | None:
    shortest = min(LINKS, key=lambda link: values[f"{link}_length"])
    length = values[f"{shortest}_length"]
    least = least_radius(length)
    thin = [
        f"{link}_radius = {values[f'{link}_radius']:g} m"
        for link in LINKS
        if values[f"{link}_radius"] < least
    ]
    if not thin:
        return None
    return (
        f"{' and '.join(thin)} is too thin for this fluid; with {shortest}_length = {length:g} m "
        f"as the shortest link, a radius must be at least {least:.4g} m"
    )


def _length(link: str) -> Parameter:
    meaning = f"length of the {link} link between the centres of its ends"
    return Parameter(
        f"{link}_length", LEAST_LENGTH, 3.0, 1.0, meaning, scale="log", search=(0.1, 3.0)
    )


def _radius(link: str) -> Parameter:
    meaning = f"radius of the {link} link"
    return Parameter(
        f"{link}_radius", 0.005, 1.0, 0.1, meaning, scale="log", search=(THINNEST, 0.3)
    )


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
    search_rules=(
        Rule(
            f"each radius >= {SLENDER:g} m^2 / (shortest length), though a radius of "
            f"{THICK_ENOUGH:g} m always suffices",
            _too_light,
        ),
    ),
    version=2,
    reward=SPEED_REWARD,
    environment="robomore.envs.robots.swimmer:SwimmerEnvironment",
)
