"""What is recorded of one episode of a trained robot: all that a fitness may depend on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # reading a task needs no NumPy
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


@dataclass(frozen=True)
class Trajectory:
    """One episode, recorded in the trusted process, sample by sample.

    There is one sample at the start and one after each control step: T + 1 samples for T steps. The
    torso is the root of the robot, its first body.

    Attributes:
        step_seconds: time between two samples, in s.
        full_steps: control steps of an episode that is not cut short by a fall.
        position: (T + 1, 3) position of the torso in the world, in m.
        upright: (T + 1,) cosine of the angle by which the torso leans away from its rest pose.
        qpos: (T + 1, nq) MuJoCo's positions, in m and rad.
        qvel: (T + 1, nv) MuJoCo's velocities, in m/s and rad/s.
        energy: (T,) mechanical energy of the motors in each control step, in J: absolute power over
            time, so that braking costs as much as driving.
        contact: (T,) bool, whether some part touches the ground.
        mass: of the robot, in kg.
        fall: why the episode ended early, such as `too_low`; empty if it did not.
        part: returns the positions (T + 1, 3) in m of a body, site or geom of that name.
    """

    step_seconds: float
    full_steps: int
    position: Array
    upright: Array
    qpos: Array
    qvel: Array
    energy: Array
    contact: NDArray[np.bool_]
    mass: float
    fall: str
    part: Callable[[str], Array]

    @property
    def steps(self) -> int:
        """Control steps of this episode."""
        return len(self.position) - 1

    @property
    def distance(self) -> float:
        """How far the torso moved forward, along x, in m."""
        return float(self.position[-1, 0] - self.position[0, 0])

    @property
    def total_energy(self) -> float:
        """Mechanical energy of the motors in the episode, in J."""
        return float(sum(self.energy.tolist()))

    def where(self, part: str) -> Array:
        """Return the positions (T + 1, 3) in m of a part; of the torso for an empty name."""
        return self.part(part) if part else self.position
