"""What episodes of known motion are worth, and what makes no fitness."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from robomore.errors import FitnessFailed, InputError
from robomore.tasks import MEASURES, Fitness, Trajectory, get_task
from robomore.tasks.fingerprint import fingerprint

STEP = 0.1


def walk(
    x: Sequence[float],
    *,
    y: float | Sequence[float] = 0.0,
    z: float | Sequence[float] = 1.0,
    lean: float | Sequence[float] = 0.0,
    joules: float = 0.0,
    full: int = 0,
) -> Trajectory:
    """Return an episode in which the torso is at these places, `STEP` s apart."""
    samples = len(x)
    columns = [np.broadcast_to(np.asarray(one, dtype=float), samples) for one in (x, y, z)]
    position = np.stack(columns, axis=1)
    return Trajectory(
        step_seconds=STEP,
        full_steps=full or samples - 1,
        position=position,
        upright=np.cos(np.broadcast_to(np.asarray(lean, dtype=float), samples)),
        qpos=position,
        qvel=np.zeros((samples, 3)),
        energy=np.full(samples - 1, joules / (samples - 1)),
        contact=np.ones(samples - 1, dtype=np.bool_),
        mass=10.0,
        fall="too_low" if full else "",
        part=lambda name: position + {"hand": [0.0, 0.0, 2.0]}[name],
    )


def at(speed: float, seconds: float, **more: Any) -> Trajectory:
    """Return a walk along x at one speed in m/s."""
    return walk(speed * STEP * np.arange(round(seconds / STEP) + 1), **more)


SQUARE = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)]
LOOP = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0), (0.0, 0.0)]
THERE_AND_BACK = [(0.0, 0.0), (10.0, 0.0), (10.0, 0.8), (0.0, 0.8)]
LANE = [(0.0, 0.0), (5.0, 0.0), (0.0, 0.0), (5.0, 0.0)]

CASES: list[tuple[str, dict[str, Any], Trajectory, float]] = [
    ("distance", {}, walk([1.0, 5.0, 3.5]), 2.5),
    ("distance", {}, walk([0.0, -1.0]), -1.0),
    ("height", {}, walk([0, 0, 0], z=[1.0, 1.7, 0.4]), 1.7),
    ("speed-kept", {"speed": 1.5}, at(1.5, 4), 1.0),
    ("speed-kept", {"speed": 2.0}, at(1.5, 4), 0.75),
    ("speed-kept", {"speed": 1.0}, at(3.0, 4), 0.0),
    ("speed-kept", {"speed": 1.0}, at(-1.0, 4), 0.0),
    ("speed-kept", {"speed": 1.5}, at(1.5, 4, full=80), 0.5),
    ("distance-per-energy", {}, at(2.0, 5, joules=50.0), 0.2),
    ("distance-per-energy", {}, at(0.1, 5, joules=0.01), 0.0),
    ("transport-economy", {}, at(2.0, 5, joules=981.0), 1.0),
    ("transport-economy", {}, at(2.0, 5, joules=0.0), 1000.0),
    # The torso is 1 m high: farther than 2 m is no fall.
    ("transport-economy", {}, at(0.38, 5, joules=10.0), 0.0),
    ("transport-economy", {}, at(0.42, 5, joules=20.601), 10.0),
    ("transport-economy", {}, at(0.18, 5, z=0.3, joules=10.0), 0.0),
    ("transport-economy", {}, at(0.22, 5, z=0.3, joules=10.791), 10.0),
    ("target-reached", {"target": (4.0, 0.0), "radius": 1.0}, at(1.0, 2), 2 / 3),
    ("target-reached", {"target": (4.0, 0.0), "radius": 1.0}, at(1.0, 4), 1.25),
    ("target-reached", {"target": (-4.0, 0.0)}, at(1.0, 4), 0.0),
    ("target-reached", {"target": (4.0, 0.0, 3.0), "radius": 0.0, "part": "hand"}, at(1.0, 5), 1.2),
    ("terrain-covered", {}, walk([1.0, 4.0, 1.0], y=[1.0, 5.0, 1.0]), 5.0),
    ("height-climbed", {}, walk(np.zeros(31), z=np.linspace(1.0, 4.0, 31)), 2.1),
    ("height-climbed", {}, walk(np.zeros(12), z=[1.0] * 11 + [9.0]), 0.0),
    ("time-upright", {}, at(0.0, 3), 3.0),
    ("time-upright", {}, at(0.0, 3, lean=[0.0] * 11 + [1.0] * 20), 1.0),
    ("time-upright", {"tilt": 1.2}, at(0.0, 3, lean=1.0), 3.0),
    ("time-upright", {"height": 0.9}, at(0.0, 3, z=[1.0] * 6 + [0.8] * 25), 0.5),
    ("path-followed", {"path": SQUARE}, at(1.0, 1.5), 1.5),
    ("path-followed", {"path": SQUARE}, at(1.0, 5), 2.0),
    ("path-followed", {"path": SQUARE, "width": 0.1}, walk([0.0, 1.0, 2.0], y=[0.0, 0.2, 0.0]), 0),
    ("path-followed", {"path": SQUARE}, walk([0.0, 1.0, 2.0, 2.2], y=[0.0, 0.1, 0.0, 1.5]), 3.5),
    # Stepping aside skips no piece, and neither does standing where two of them lie side by side.
    ("path-followed", {"path": LOOP}, walk([0.0, 0.0, 0.0], y=[0.0, 0.4, 0.6]), 0.0),
    ("path-followed", {"path": THERE_AND_BACK}, walk([0.0, 0.0, 0.0], y=[0.0, 0.4, 0.6]), 0.0),
    ("path-followed", {"path": LANE}, walk([0.0, 1.0, 0.5], y=0.1), 1.0),
    ("path-followed", {"path": LANE}, at(1.0, 5), 5.0),
    # A corner may be cut within the width of both pieces.
    ("path-followed", {"path": SQUARE}, walk([0.0, 1.55, 1.65, 2.0], y=[0.0, 0.3, 0.4, 1.0]), 3.0),
    ("path-followed", {"path": SQUARE}, walk([0.0, 1.0, 1.3, 2.0], y=[0.0, 0.3, 0.6, 1.0]), 1.0),
]


@pytest.mark.parametrize(("name", "options", "episode", "worth"), CASES)
def test_a_known_motion_has_its_known_worth(
    name: str, options: dict[str, Any], episode: Trajectory, worth: float
) -> None:
    assert Fitness.of(name, **options)(episode) == pytest.approx(worth)


def test_every_measure_is_tried_above_and_says_what_it_is() -> None:
    assert {name for name, *_ in CASES} == set(MEASURES) - {"energy"}
    for name, measure in MEASURES.items():
        assert measure.meaning and measure.higher_is_better == (name != "energy")
    kept = Fitness.of("speed-kept", speed=1.5)
    assert "a speed of 1.5 m/s" in kept.meaning
    assert (kept.unit, kept.per_volume) == ("", "1/m³")
    assert "(4, 0) m" in Fitness.of("target-reached", target=(4.0, 0.0)).meaning


def test_measures_are_added_with_their_weights() -> None:
    frugal = Fitness.sum((1.0, "distance"), (-0.01, "energy"), unit="m")
    assert frugal(at(2.0, 5, joules=300.0)) == pytest.approx(10 - 3)
    assert frugal.name == "1 distance -0.01 energy"
    assert frugal.may_be_negative and frugal.unit == "m"
    twice = Fitness.sum((2.0, "distance"), (0.5, frugal))
    assert twice(at(2.0, 5, joules=300.0)) == pytest.approx(20 + 3.5)
    assert twice.unit == "", "metres and joules have no unit in common"
    both = Fitness.sum((1.0, "distance"), (0.5, "height"))
    assert both.unit == "m" and not both.may_be_negative
    assert "0.5 times the greatest height" in both.meaning


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Fitness.of("distanc"), "Did you mean 'distance'.*path-followed"),
        (lambda: Fitness.of("energy"), "less energy is better.*take distance-per-energy"),
        (lambda: Fitness.sum((0.5, "energy")), "negative weight"),
        (lambda: Fitness.sum((math.nan, "distance")), "weight of 'distance' is nan"),
        (lambda: Fitness.sum(), "at least one measure"),
        (lambda: Fitness.of("speed-kept"), r"needs speed: Fitness.of\('speed-kept', speed=…\)"),
        (lambda: Fitness.of("distance", speed=1), "no option 'speed'. It takes none"),
        (lambda: Fitness.of("speed-kept", speed=0.0), "speed = 0.0; give a number from 0.001 to"),
        (lambda: Fitness.of("speed-kept", speed=math.nan), "speed = nan; give .* m/s"),
        (lambda: Fitness.of("speed-kept", speed="fast"), "speed = 'fast'; give a number"),
        (lambda: Fitness.of("time-upright", tilt=45.0), "to 3.14 rad .45 degrees are 0.785 rad"),
        (lambda: Fitness.of("target-reached", target=(1, 0), radius=-1), "radius = -1; give"),
        (lambda: Fitness.of("target-reached", target=(1,)), r"target = \(1,\); give \(x, y\) or"),
        (lambda: Fitness.of("target-reached", target=(1, 0), part=3), "part = 3; give the name"),
        (lambda: Fitness.of("path-followed", path=[(0, 0)]), "give two points"),
        (lambda: Fitness.of("path-followed", path=[(0, 0, 0), (1, 0, 0)]), r"points \(x, y\) in m"),
        (lambda: Fitness.of("path-followed", path=[(0, 0), (1, 0), (1, 0)]), r"\[1, 0\] stands"),
        (lambda: Fitness.of("path-followed", path=SQUARE, width=0), "width = 0; give"),
    ],
)
def test_what_makes_no_fitness_is_refused_with_the_remedy(make: Any, said: str) -> None:
    with pytest.raises(InputError, match=said):
        make()


@pytest.mark.parametrize(
    ("fitness", "said"),
    [
        ("energy", "swimmer: less energy is better"),
        ("far", "swimmer: no fitness measure is called 'far'"),
        (3, "swimmer: the fitness is 3; give the name of a measure"),
        (abs, r"swimmer: the fitness is a function; .*Fitness.own\("),
    ],
)
def test_a_task_names_its_fault(fitness: Any, said: str) -> None:
    with pytest.raises(InputError, match=said):
        replace(get_task("swimmer"), fitness=fitness)


def best_of_two(trajectory: Trajectory, bonus: float = 0.0) -> float:
    return max(trajectory.distance, float(trajectory.position[:, 2].max())) + bonus


def test_a_function_of_one_s_own_is_part_of_the_task() -> None:
    def own(function: Any) -> Fitness:
        return Fitness.own(function, unit="m", meaning="the better of way and height")

    mine = own(best_of_two)
    assert mine(walk([0.0, 2.0], z=[1.0, 3.0])) == 3.0
    assert (mine.name, mine.meaning, mine.unit) == ("own", "the better of way and height", "m")
    swimmer = get_task("swimmer")
    keys = {
        fingerprint(replace(swimmer, fitness=one))["fitness"]
        for one in (mine, own(best_of_two), own(partial(best_of_two, bonus=1.0)), "distance")
    }
    assert len(keys) == 3, "the same function counts as the same"


@pytest.mark.parametrize(
    ("function", "said"),
    [(lambda episode: episode.speed, "raised AttributeError"), (lambda episode: math.nan, "nan")],
)
def test_a_faulty_function_fails_with_a_diagnosis(function: Any, said: str) -> None:
    with pytest.raises(FitnessFailed, match=said):
        Fitness.own(function, unit="", meaning="broken")(at(1.0, 1))


def test_a_sum_without_a_finite_value_fails_with_a_diagnosis() -> None:
    def large(episode: Trajectory) -> float:
        return 1e300

    one = Fitness.own(large, unit="", meaning="large")
    with pytest.raises(FitnessFailed, match="gave inf; use smaller weights"):
        Fitness.sum((1e10, one), (1.0, one))(at(1.0, 1))
