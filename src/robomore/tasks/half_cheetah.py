"""Half-Cheetah: a two-legged runner in a vertical plane."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import accumulate

from robomore.tasks.geometry import LEAST_LENGTH
from robomore.tasks.swimmer import SPEED_REWARD
from robomore.tasks.task import Parameter, Rule, Task, Values
from robomore.tasks.template import read_asset

LEGS = ("back", "front")
SEGMENTS = ("thigh", "shin", "foot")
LIMBS = tuple(f"{leg}_{segment}" for leg in LEGS for segment in SEGMENTS)

LEAST_SEGMENT = 0.03
"""Shortest head and leg segment that samplers draw, in m."""

REFERENCE_VECTORS = {
    "head": (0.229299, 0.193448),
    "back_thigh": (0.177439, -0.229381),
    "back_shin": (-0.268922, -0.132970),
    "back_foot": (0.050146, -0.181189),
    "front_thigh": (-0.132170, -0.230840),
    "front_shin": (0.119704, -0.174971),
    "front_foot": (0.079050, -0.115547),
}
"""End-to-end vectors (x, z) in m of the official robot's capsules, from angle and length."""

REFERENCE_RADIUS = 0.046
"""Of every part of the official robot, in m."""


def start_height(values: Values) -> float:
    """Return the torso's height at the start, in m: both legs straight down as drawn."""
    return max(abs(sum(values[f"{leg}_{segment}_z"] for segment in SEGMENTS)) for leg in LEGS)


def _length(values: Values, part: str) -> float:
    return math.hypot(values[f"{part}_x"], values[f"{part}_z"])


def _too_short(least: float) -> Callable[[Values], str | None]:
    def violation(values: Values) -> str | None:
        wrong = [
            f"{part}_x = {values[f'{part}_x']:g} m and {part}_z = {values[f'{part}_z']:g} m make a "
            f"{part} of {_length(values, part):.4g} m, shorter than {least:g} m"
            for part in ("head", *LIMBS)
            if _length(values, part) < least
        ]
        return "; ".join(wrong) or None

    return violation


def _starts_in_ground(values: Values) -> str | None:
    height = start_height(values)
    depths = {"head_z": values["head_z"]}
    for leg in LEGS:
        names = [f"{leg}_{segment}_z" for segment in SEGMENTS]
        sums = accumulate(values[name] for name in names)
        depths |= {" + ".join(names[: i + 1]): z for i, z in enumerate(sums)}
    # The leg that sets the start height ends exactly on the ground, up to rounding.
    wrong = [
        f"{name} = {z:.4g} m is below the ground, which is at {-height:.4g} m from the torso"
        for name, z in depths.items()
        if z < -height - 1e-9
    ]
    return "; ".join(wrong) or None


def _legs_upward(values: Values) -> str | None:
    wrong = []
    for leg in LEGS:
        names = [f"{leg}_{segment}_z" for segment in SEGMENTS]
        end = sum(values[name] for name in names)
        if end >= 0:
            wrong.append(f"{' + '.join(names)} = {end:.4g} m is not below the torso (0 m)")
    return "; ".join(wrong) or None


def _too_thick(values: Values) -> str | None:
    height = start_height(values)
    names = [f"{part}_radius" for part in ("torso", "head", *LIMBS)]
    thick = [f"{name} = {values[name]:g} m" for name in names if values[name] > height]
    if not thick:
        return None
    return f"{' and '.join(thick)} is more than the torso's start height of {height:.4g} m"


def _vector(part: str, low: float, high: float, words: str) -> tuple[Parameter, Parameter]:
    x, z = REFERENCE_VECTORS[part]
    return (
        Parameter(f"{part}_x", -2.5, 2.5, x, f"x {words}", search=(-1.0, 1.0)),
        Parameter(f"{part}_z", -2.5, 2.5, z, f"z {words}", search=(low, high)),
    )


def _leg(leg: str) -> tuple[Parameter, ...]:
    thigh, shin, foot = (f"{leg}_{segment}" for segment in SEGMENTS)
    return (
        *_vector(thigh, -1.0, 0.5, f"from the {leg} hip to the {leg} knee"),
        *_vector(shin, -1.0, 0.5, f"from the {leg} knee to the {leg} ankle"),
        *_vector(foot, -1.0, 0.5, f"from the {leg} ankle to the {leg} foot's tip"),
    )


def _radius(part: str) -> Parameter:
    words = f"radius of the {part.replace('_', ' ')}"
    return Parameter(
        f"{part}_radius", 0.005, 1.0, REFERENCE_RADIUS, words, scale="log", search=(0.005, 0.2)
    )


def _torso_end(name: str, low: float, high: float, reference: float, words: str) -> Parameter:
    bounds = (-3.0, -LEAST_LENGTH) if high < 0 else (LEAST_LENGTH, 3.0)
    return Parameter(name, *bounds, reference, words, search=(low, high))


HALF_CHEETAH = Task(
    id="half-cheetah",
    title="Half-Cheetah",
    description=(
        "The half-cheetah is a two-legged robot that moves in a vertical plane. Its torso lies "
        "along x, with a head fixed to the front end, and has one leg at each end: a back and a "
        "front leg, each of a thigh, a shin and a foot. Six motors turn the six hinges: hip, knee "
        "and ankle of each leg; the joints are springy. The robot weighs 14 kg whatever its "
        "volume. The goal is to run forward, in the direction of +x (to the right), as fast as "
        "possible, by choosing the torques on the six hinges."
    ),
    fitness="distance",
    template=read_asset("half_cheetah.xml"),
    parameters=(
        _torso_end("torso_back", -1.5, -0.05, -0.5, "x of the torso's back end, the back hip"),
        _torso_end("torso_front", 0.05, 1.5, 0.5, "x of the torso's front end, the front hip"),
        *_vector("head", -1.0, 1.0, "from the torso's front end to the head's end"),
        *_leg("back"),
        *_leg("front"),
        *map(_radius, ("torso", "head", *LIMBS)),
    ),
    rules=(Rule("head and leg segments must each have a length", _too_short(LEAST_LENGTH)),),
    search_rules=(
        Rule(
            f"head and leg segments are each at least {LEAST_SEGMENT:g} m long",
            _too_short(LEAST_SEGMENT),
        ),
        Rule(
            "each leg ends below the torso: the z of its thigh, shin and foot add up to less "
            "than 0",
            _legs_upward,
        ),
        Rule(
            "no joint and no end starts below the ground, which is as far below the torso as "
            "the longer leg reaches: max |thigh_z + shin_z + foot_z| over the two legs",
            _starts_in_ground,
        ),
        Rule("no radius is larger than the torso's start height", _too_thick),
    ),
    version=2,
    reward=SPEED_REWARD,
    environment="robomore.envs.robots.half_cheetah:HalfCheetahEnvironment",
    constants={"pi": math.pi},
)
