"""Numbers and places in words, the same in the terminal and on the page."""

from __future__ import annotations

import math

from robomore.statistics.spread import Spread
from robomore.tasks.fitness import per_volume
from robomore.types import Evaluation


def number(value: float | None, digits: int = 4) -> str:
    """Return `value` with so many significant digits, thousands apart, as 1e+12 from there on."""
    if value is None or not math.isfinite(value):
        return "-"
    if value == 0:
        return "0"
    places = digits - 1 - math.floor(math.log10(abs(value)))
    if places > 8 or places < digits - 12:
        return f"{value:.{digits - 1}e}"
    rounded = round(value, places)
    return f"{rounded:,.{max(0, places)}f}"


def short(value: float) -> str:
    """Return a round number, a bound or a tick, without needless zeros."""
    return f"{value:,.6g}" if abs(value) < 1e6 else number(value)


def unit_of(objective: str, fitness: str) -> str:
    """Return the unit of what is compared; empty for a number without one.

    Args:
        objective: what is compared.
        fitness: the unit of the task's fitness (`Fitness.unit`).
    """
    return {"efficiency": per_volume(fitness), "fitness": fitness}.get(objective, "")


def in_unit(value: float | None, objective: str, fitness: str) -> str:
    """Return a score with its unit, or with its name where it has no unit; see `unit_of`."""
    unit = unit_of(objective, fitness) or f"({objective.replace('-', ' ')})"
    return f"{number(value)} {unit}"


def equation(evaluation: Evaluation, fitness: str) -> str:
    """Return fitness over volume as a formula in units: `14.9 m / 0.0212 m³`."""
    worth = f"{number(evaluation.fitness)} {fitness}".rstrip()
    return f"{worth} / {number(evaluation.volume)} m³"


def with_interval(measured: Spread, unit: str = "", digits: int = 4) -> str:
    """Return a mean as it is told everywhere: with its interval, or with all its values.

    `14.9 m (95 % interval 13.2 to 16.9, 5 seeds)`, or `14.9 m (seeds: 13.2, 16.6)` where there are
    too few seeds for an interval. A ratio has two sides, so that values of one of them would look
    like a spread that it does not have: `12.2 (no interval: 3 seeds, and it takes 5)`.
    """
    text = number(measured.mean, digits) + (f" {unit}" if unit else "")
    count = len(measured.values)
    if measured.interval is not None:
        low, high = (number(end, 3) for end in measured.interval)
        return f"{text} (95 % interval {low} to {high}, {count} seeds)"
    if measured.withheld:
        return f"{text} (no interval: {measured.withheld})"
    if count == 1:
        return f"{text} (1 seed)"
    return f"{text} (seeds: {', '.join(number(value, 3) for value in measured.values)})"


def duration(seconds: float) -> str:
    """Return a duration as people say it: `42 s`, `3 min 20 s`, `2 h 05 min`."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


LABELS = {
    "transport-economy": "transport economy (1 / cost of transport)",
    "volume": "volume (m³)",
    "mass": "mass (kg)",
    "density": "mass divided by volume (kg/m³)",
    "rest_height": "height of the torso at rest (m)",
    "forward_distance_m": "forward distance (m)",
    "forward_speed_m_s": "forward speed (m/s)",
    "highest_torso_m": "highest point of the torso (m)",
    "height_gain_m": "height gained over the start (m)",
    "lowest_torso_m": "lowest point of the torso (m)",
    "episode_seconds": "length of an episode (s)",
    "fell_share": "episodes that ended in a fall",
    "mean_effort": "mean size of an action (at most 1)",
    "mean_jerk": "mean change of an action per step (at most 2)",
    "energy_j": "mechanical energy of an episode (J)",
    "ground_contact_share": "time with contact to the ground",
    "stride_frequency_hz": "stride frequency (Hz)",
    "joint_amplitude_rad": "mean amplitude of the driven hinges (rad)",
    "saturated_share": "motor commands at their limit",
    "sideways_drift_m": "sideways drift of the torso (m)",
    "turn_rad": "turn about the vertical axis (rad)",
    "fell_too_low_share": "falls with the torso too low",
    "fell_too_high_share": "falls with the torso too high",
    "fell_tilted_share": "falls with the torso tilted",
    "fell_diverged_share": "falls because the simulation diverged",
    "fell_unhealthy_share": "falls by another limit of health",
}
"""What numbers are called before people, by the names that they have in evaluations."""

_UNITS = {
    "_m_s": "m/s",
    "_m": "m",
    "_seconds": "s",
    "_kg": "kg",
    "_j": "J",
    "_hz": "Hz",
    "_rad": "rad",
}


def label(name: str, fitness: str = "") -> str:
    """Return what a number is called before people, its unit in brackets.

    A name that is not in the table is put into words: `step_length_m` is `step length (m)`.

    Args:
        name: of the number.
        fitness: the unit of the task's fitness, which that of `efficiency` follows from.
    """
    if name in ("efficiency", "fitness"):
        unit = unit_of(name, fitness)
        return f"{name} ({unit})" if unit else name
    if name in LABELS:
        return LABELS[name]
    for ending, unit in _UNITS.items():
        if name.endswith(ending):
            return f"{name.removesuffix(ending).replace('_', ' ')} ({unit})"
    return name.replace("_", " ")


def measured(name: str, value: float | None) -> str:
    """Return the value of a number of that name, in the unit of its label."""
    if name.endswith("_share") and value is not None:
        return f"{number(100 * value, 3)} %"
    return number(value)
