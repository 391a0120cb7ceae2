"""What a free parameter changes on a robot, and what moves a robot that has no motors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Change = Literal["length", "radius", "strength"]

MassMode = Literal["density", "shell", "length"]

MASS_MODES: dict[str, str] = {
    "density": "each solid keeps its density, so a larger part is heavier by its volume",
    "shell": "a part of each link's mass is payload that stays as it is; the rest grows with the "
    "link's length and thickness",
    "length": "a link's mass grows with its length and not with its thickness",
}
"""How the mass of a changed link follows from its size."""


@dataclass(frozen=True, slots=True)
class Edit:
    """What one free parameter does.

    Attributes:
        name: of the parameter.
        changes: `length` or `radius` of links, or the `strength` (largest torque or force) of the
            motors on joints.
        parts: names of the links, or of the joints.
        reference: value in m, or N·m, that leaves the robot as it is.
    """

    name: str
    changes: Change
    parts: tuple[str, ...]
    reference: float


@dataclass(frozen=True, slots=True)
class MotorGroup:
    """Motors that are added to joints.

    Attributes:
        joints: their names.
        kind: `servo` holds an angle or a position, `motor` applies a torque or a force.
        torque: the largest one, in N·m (N for a sliding joint).
        stiffness: of a servo, in N·m/rad (N/m).
        damping: of a servo, in N·m·s/rad (N·s/m).
        armature: inertia of the rotor, as the joint feels it, in kg·m² (kg).
    """

    joints: tuple[str, ...]
    kind: Literal["servo", "motor"]
    torque: float
    stiffness: float = 0.0
    damping: float = 0.0
    armature: float = 0.0
