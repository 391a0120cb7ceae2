"""The measures that a fitness can be made of, by name.

Each is a function of one recorded episode. What is no better for being larger says so: a search
makes fitness as large as it can.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from robomore.registry import Registry
from robomore.tasks.measure_options import OptionCheck, number, part, path, target
from robomore.tasks.trajectory import Trajectory
from robomore.transport import GRAVITY, cost_of_transport


@dataclass(frozen=True, slots=True)
class FitnessMeasure:
    """One number that an episode is worth.

    Attributes:
        meaning: in words for designers and people; `{…}` holds options by name.
        unit: SI unit; empty for a number without one.
        function: returns the measure of a trajectory; options are keyword arguments.
        options: default value of each option; `None` for one that has to be given.
        higher_is_better: whether more of it is better.
        motion: where it leads: forward, upward, or `other`. The offline designer looks at it.
        instead: of one where less is better: what to take as a fitness.
        checks: of options by name: each says what may stand there in place of what does not fit.
    """

    meaning: str
    unit: str
    function: Callable[..., float]
    options: Mapping[str, Any] = field(default_factory=dict)
    higher_is_better: bool = True
    motion: Literal["forward", "upward", "other"] = "forward"
    instead: str = ""
    checks: Mapping[str, OptionCheck] = field(default_factory=dict)


def distance(trajectory: Trajectory) -> float:
    """How far the torso got forward, in m."""
    return trajectory.distance


def height(trajectory: Trajectory) -> float:
    """Highest torso height, in m."""
    return float(trajectory.position[:, 2].max())


def energy(trajectory: Trajectory) -> float:
    """Mechanical energy of the motors, in J."""
    return trajectory.total_energy


def speed_kept(trajectory: Trajectory, speed: float) -> float:
    """How well a speed along x is kept, from 0 to 1.

    Each second of a full episode counts alike: 1 where the mean speed in it is `speed` m/s, less in
    proportion to how far it is off, and 0 from twice the speed and from a standstill on. The
    seconds that a fall leaves out count as 0.
    """
    size = max(1, round(1 / trajectory.step_seconds))
    x = trajectory.position[:, 0]
    kept = 0.0
    for first in range(0, trajectory.steps, size):
        last = min(first + size, trajectory.steps)
        mean = float(x[last] - x[first]) / ((last - first) * trajectory.step_seconds)
        kept += (last - first) * max(0.0, 1 - abs(mean - speed) / abs(speed))
    return kept / trajectory.full_steps


def distance_per_energy(trajectory: Trajectory) -> float:
    """Distance over the energy of the motors, in m/J; 0 where the economy is."""
    return transport_economy(trajectory) / (trajectory.mass * GRAVITY)


def transport_economy(trajectory: Trajectory) -> float:
    """1 / cost of transport: mass * 9.81 m/s² * distance / energy.

    0 for less than 1 m, and for less than twice the height of the torso at the start, which a robot
    that only falls over forward can get.
    """
    height = float(trajectory.position[0, 2])
    cost = cost_of_transport(trajectory.distance, trajectory.total_energy, trajectory.mass, height)
    return 0.0 if cost is None else 1 / cost


def target_reached(
    trajectory: Trajectory, target: Sequence[float], radius: float, part: str
) -> float:
    """The part of the way to a target that was covered, and more the earlier it is reached.

    0 at the start and 1 where the part comes within `radius` m of `target`; then the part of the
    episode's time that is left is added, so that 2 is the most.
    """
    places = trajectory.where(part)[:, : len(target)]
    away = (((places - target) ** 2).sum(axis=1) ** 0.5 - radius).clip(0)
    if float(away.min()) > 0:
        return max(0.0, 1 - float(away.min()) / float(away[0]))
    return 2 - int((away <= 0).argmax()) / trajectory.full_steps


def terrain_covered(trajectory: Trajectory) -> float:
    """Farthest horizontal distance of the torso from its start, whatever the direction, in m."""
    away = trajectory.position[:, :2] - trajectory.position[0, :2]
    return float(((away**2).sum(axis=1) ** 0.5).max())


def height_climbed(trajectory: Trajectory) -> float:
    """How much higher the torso stays in the last second than at the start, in m.

    The lowest height of that second counts, so that a jump at the end gains nothing; and so does a
    loss, as less than 0.
    """
    last = max(1, round(1 / trajectory.step_seconds))
    heights = trajectory.position[:, 2]
    return float(heights[-last:].min() - heights[0])


def time_upright(trajectory: Trajectory, tilt: float, height: float) -> float:
    """Time in s in which the torso leans less than `tilt` rad, and is higher than `height` times
    its height at the start."""
    heights = trajectory.position[1:, 2]
    stands = trajectory.upright[1:] > math.cos(tilt)
    stands &= heights > height * float(trajectory.position[0, 2])
    return float(stands.sum()) * trajectory.step_seconds


def path_followed(
    trajectory: Trajectory, path: Sequence[Sequence[float]], width: float, part: str
) -> float:
    """Length in m of a path of straight pieces that was followed without leaving it.

    The part is followed along the path from its first point on, piece by piece: it is on the next
    piece once it is nearer to it, or has come to the end of this one, and at most `width` m are
    left of this one. It ends where the part is farther than `width` m from its piece.
    """
    import numpy as np  # reading a task needs no NumPy

    points = np.array(path, dtype=float)
    lengths = np.hypot(*np.diff(points, axis=0).T)

    def placed(place: Any, piece: int) -> tuple[float, float]:
        """Return how far along a piece the nearest point to a place is, and how far away."""
        start, course = points[piece], (points[piece + 1] - points[piece]) / lengths[piece]
        along = min(max(float(np.dot(place - start, course)), 0.0), float(lengths[piece]))
        return along, float(np.hypot(*(start + course * along - place)))

    piece, best = 0, 0.0
    for place in trajectory.where(part)[:, :2]:
        along, off = placed(place, piece)
        while piece + 2 < len(points):
            left = float(lengths[piece]) - along
            further, beside = placed(place, piece + 1)
            if left > width or beside > width or (left > 0 and beside >= off):
                break
            piece, along, off = piece + 1, further, beside
        if off > width:
            break
        best = max(best, float(lengths[:piece].sum()) + along)
    return best


BUILT_IN: dict[str, FitnessMeasure] = {
    "distance": FitnessMeasure(
        "how far the torso gets in the direction of +x in an episode", "m", distance
    ),
    "height": FitnessMeasure(
        "the greatest height of the torso in an episode", "m", height, motion="upward"
    ),
    "speed-kept": FitnessMeasure(
        "how well the torso keeps a speed of {speed} m/s in the direction of +x: each second of a "
        "full episode counts 1 - |mean speed - {speed}| / {speed}, at least 0, and 0 after a fall; "
        "the mean of it, from 0 to 1",
        "",
        speed_kept,
        {"speed": None},
        checks={"speed": number(0.001, 1000, "m/s", backward=True)},
    ),
    "distance-per-energy": FitnessMeasure(
        "how far the torso gets in the direction of +x for each joule of mechanical energy of the "
        "motors, and 0 for less than 1 m or less than twice the height of the torso at the start",
        "m/J",
        distance_per_energy,
    ),
    "transport-economy": FitnessMeasure(
        "1 / cost of transport: mass * 9.81 m/s² * distance in the direction of +x / mechanical "
        "energy of the motors, and 0 for less than 1 m or less than twice the height of the torso "
        "at the start",
        "",
        transport_economy,
    ),
    "target-reached": FitnessMeasure(
        "how much of the way to the target {target} m is covered, 1 within {radius} m of it, and "
        "then the part of the episode's time that is left on top; the most is 2",
        "",
        target_reached,
        {"target": None, "radius": 0.5, "part": ""},
        motion="other",
        checks={"target": target, "radius": number(0, 1000, "m"), "part": part},
    ),
    "terrain-covered": FitnessMeasure(
        "the farthest horizontal distance of the torso from its start in an episode, whatever the "
        "direction",
        "m",
        terrain_covered,
    ),
    "height-climbed": FitnessMeasure(
        "how much higher than at its start the torso is at the lowest point of the last second of "
        "an episode",
        "m",
        height_climbed,
    ),
    "time-upright": FitnessMeasure(
        "the time of an episode in which the torso leans less than {tilt} rad and is higher than "
        "{height} times its height at the start",
        "s",
        time_upright,
        {"tilt": 0.8, "height": 0.5},
        motion="other",
        checks={
            "tilt": number(0.001, 3.14, "rad (45 degrees are 0.785 rad)"),
            "height": number(0, 10),
        },
    ),
    "path-followed": FitnessMeasure(
        "how far the path through the points {path} m is followed, from its start on, without ever "
        "being farther than {width} m from it",
        "m",
        path_followed,
        {"path": None, "width": 0.5, "part": ""},
        motion="other",
        checks={"path": path, "width": number(0.001, 1000, "m"), "part": part},
    ),
    "energy": FitnessMeasure(
        "the mechanical energy of the motors in an episode",
        "J",
        energy,
        higher_is_better=False,
        motion="other",
        instead="distance-per-energy or transport-economy",
    ),
}


def _fault(name: str, found: object) -> str:
    is_one = isinstance(found, FitnessMeasure)
    return "" if is_one else f"is a {type(found).__name__}, no FitnessMeasure"


MEASURES: Registry[FitnessMeasure] = Registry(
    "fitness measure", "robomore.fitness", BUILT_IN, _fault
)
"""Measures by name. The entry-point group is `robomore.fitness`."""
