"""Cost of transport: what it takes to carry one's own weight one metre, and who carries it at all.

The objective of a search and the fitness of a task of that name are this one number.
"""

from __future__ import annotations

GRAVITY = 9.81
"""In m/s^2. It is the same for tasks without gravity, so that costs of transport compare."""

LEAST_DISTANCE = 1.0
"""Distance in m below which nothing is transported: a robot that drifts spends almost nothing."""

LEAST_HEIGHTS = 2.0
"""The same in heights of the torso. Falling over carries a torso forward by its own height at the
most, and the energy of the fall lets it slide by its height over the friction's coefficient (1 in
our tasks). Both are free, since the motors do no work, so they must not count."""

CHEAPEST = 0.001
"""Least cost of transport that is counted. No machine with legs comes near it, but a robot that is
thrown forward by a fault of the simulation spends almost nothing."""


def cost_of_transport(distance: float, energy: float, mass: float, height: float) -> float | None:
    """Return energy / (mass * gravity * distance), without a unit; `CHEAPEST` at the least.

    Args:
        distance: forward, in m.
        energy: mechanical energy of the motors on the way, in J.
        mass: of the robot, in kg.
        height: of the torso before it moves, in m.

    Returns:
        `None` for less than 1 m or less than twice the height, which a fall gives for nothing.
    """
    if distance < max(LEAST_DISTANCE, LEAST_HEIGHTS * height) or mass <= 0:
        return None
    return max(energy / mass / GRAVITY / distance, CHEAPEST)
