"""Volumes of the solids that MuJoCo robots are made of."""

from __future__ import annotations

import math
from dataclasses import dataclass

LEAST_LENGTH = 1e-6
"""Shortest capsule between the centres of its ends, in m. MuJoCo compiles one of this length and
refuses one of 1e-9 m (`fromto points too close`)."""


@dataclass(frozen=True, slots=True)
class Capsule:
    """A cylinder with a half sphere on each end.

    Attributes:
        radius: in m.
        length: of the cylinder between the half spheres' centres, in m.
        count: how many of them the robot has.
    """

    radius: float
    length: float
    count: int = 1

    @property
    def volume(self) -> float:
        """In m³: count * pi r^2 (length + 4 r / 3)."""
        return self.count * math.pi * self.radius**2 * (self.length + 4 * self.radius / 3)


@dataclass(frozen=True, slots=True)
class Sphere:
    """A ball of `radius` m."""

    radius: float

    @property
    def volume(self) -> float:
        """In m³: 4/3 pi r^3."""
        return 4 / 3 * math.pi * self.radius**3


@dataclass(frozen=True, slots=True)
class Solid:
    """A box, a cylinder, an ellipsoid or a mesh.

    Attributes:
        volume: in m³.
    """

    volume: float

    @property
    def radius(self) -> float:
        """Radius in m of the ball that has this volume: a measure of its size."""
        return float((3 * self.volume / (4 * math.pi)) ** (1 / 3))


Shape = Capsule | Sphere | Solid
