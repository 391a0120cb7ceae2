"""The largest force of motors and servos, read from a model."""

from __future__ import annotations

import math

import mujoco
import pytest

from robomore.envs.motor_force import joint_force, motor_force

MOTOR = '<motor joint="j" ctrlrange="-2 1" gear="50"/>'
SERVO = '<position joint="j" kp="40" ctrlrange="-2.094 2.094" {}/>'


@pytest.mark.parametrize(
    ("joint", "actuators", "each", "together"),
    [
        ("", MOTOR, 100.0, 100.0),
        ("", '<motor joint="j" ctrlrange="-1 1" forcerange="-0.5 0.5" gear="50"/>', 25.0, 25.0),
        ("", SERVO.format('forcerange="-20 20"'), 20.0, 20.0),
        ("", SERVO.format('forcerange="-20 20" gear="3"'), 60.0, 60.0),
        ('actuatorfrcrange="-6 7"', SERVO.format(""), 7.0, 7.0),
        ('actuatorfrcrange="-6 7"', MOTOR + MOTOR, 7.0, 7.0),
        ("", MOTOR + MOTOR, 100.0, 200.0),
        ('actuatorfrcrange="-120 120"', MOTOR, 100.0, 100.0),
        ('actuatorfrcrange="-150 150"', MOTOR + MOTOR, 100.0, 150.0),
        ("", SERVO.format(""), math.inf, math.inf),
        ("", '<motor joint="j" gear="50"/>', math.inf, math.inf),
    ],
)
def test_a_range_of_angles_is_no_force(
    joint: str, actuators: str, each: float, together: float
) -> None:
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><body><joint name="j" {joint}/><geom size="0.1"/></body></worldbody>'
        f"<actuator>{actuators}</actuator></mujoco>"
    )
    assert motor_force(model, 0) == pytest.approx(each)
    assert joint_force(model, 0) == pytest.approx(together)
