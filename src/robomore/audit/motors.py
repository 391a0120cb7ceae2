"""Are the motors in proportion to the robot?"""

from __future__ import annotations

import math

import mujoco

from robomore.audit.subject import Subject
from robomore.envs.compile import compile_model
from robomore.envs.motor_force import motor_force
from robomore.runs.words import number
from robomore.store.audit import Verdict
from robomore.tasks.task import Task

_CHECK = "motor strength against mass"
WARNS_ABOVE = 10.0
"""Times the reference design's torque for each kg. The task fixes the motors, whatever the robot
weighs: a thin robot gets them for nothing. A good electric joint gives some tens of N m for each kg
of its own, and the official Ant, with 170, is beyond that already, so it never fails."""


def check(subject: Subject) -> Verdict:
    """Compare the strongest motor's torque over the robot's mass with the reference design's."""
    torque, own = _strength(subject.task, subject.parameters)
    _, reference = _strength(subject.task, subject.task.reference)
    if math.isinf(torque) or math.isinf(reference):
        return Verdict(
            _CHECK,
            "skipped",
            "Nothing limits the force of a motor, so it has no strength to compare: give a servo a "
            "forcerange, and a plain motor a ctrlrange.",
        )
    times = own / reference if reference else 1.0
    return Verdict(
        _CHECK,
        "warns" if times > WARNS_ABOVE else "passes",
        f"The strongest motor has {number(torque)} N·m on {number(subject.facts['mass'])} kg: "
        f"{number(own)} N·m/kg, {number(times)} times the reference design's.",
        {"torque_nm": torque, "torque_nm_per_kg": own, "times_reference": times},
    )


def _strength(task: Task, parameters: tuple[float, ...]) -> tuple[float, float]:
    """Return the largest torque of a motor in N m, and that over the robot's mass.

    Both are infinite if nothing limits a motor.
    """
    model: mujoco.MjModel = compile_model(task, parameters)
    torque = max((motor_force(model, motor) for motor in range(model.nu)), default=0.0)
    return torque, torque / float(model.body_mass[1:].sum())
