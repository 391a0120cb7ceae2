# Composed without an LLM, from: early_progress 7.6, alive 0.5, activity 0.15, power 0.0055, joint_speed 0.0012 (balance).
import numpy as np


def _get_rew(self, x_velocity, action):
    """Start to move, with diminishing returns; stay healthy; moving joints; little energy; slow joints."""
    # The first metre per second is worth the most, so that learning starts early.
    early_progress = 7.6 * np.sign(x_velocity) * np.log1p(np.abs(x_velocity))

    # A bonus for every step in which the robot has not fallen.
    alive = 0.5 * float(self.is_healthy)

    # A small reward for motion of the joints, so that the robot does not stand still.
    activity = 0.15 * np.tanh(np.mean(np.abs(self.data.qvel[3:6])) / 5.0)

    # Mechanical power: torque times joint speed, summed over the motors.
    power = 0.0055 * np.sum(np.abs(action * self.data.qvel[3:6]))

    # Squared joint speeds.
    joint_speed = 0.0012 * np.mean(np.square(self.data.qvel[3:6]))

    gain = early_progress + alive + activity
    price = power + joint_speed
    terms = {
        "early_progress": early_progress,
        "alive": alive,
        "activity": activity,
        "power": -power,
        "joint_speed": -joint_speed,
    }
    return gain - price, terms
