# Composed without an LLM, from: steady_pace 4, alive 0.46, facing_ahead 0.36, riding_height 0.11, strain 0.14 (balance).
import numpy as np


def _get_rew(self, x_velocity, action):
    """Reach a steady speed, then run faster; stay healthy; straight heading; constant torso height; little mean torque."""
    # Most of the reward is for about 2 m/s; more speed still adds some.
    steady_pace = 4 * (np.tanh(0.5 * x_velocity) + 0.2 * x_velocity)

    # A bonus for every step in which the robot has not fallen.
    alive = 0.46 * float(self.is_healthy)

    # 1 when the torso points along the course.
    facing_ahead = 0.36 * (1 - 2 * (self.data.qpos[5] ** 2 + self.data.qpos[6] ** 2))

    # Keeps the torso near its starting height.
    riding_height = 0.11 * np.exp(-8.0 * np.square(self.data.qpos[2] - self.init_qpos[2]))

    # Mean absolute torque.
    strain = 0.14 * np.mean(np.abs(action))

    gain = steady_pace + alive + facing_ahead + riding_height
    price = strain
    terms = {
        "steady_pace": steady_pace,
        "alive": alive,
        "facing_ahead": facing_ahead,
        "riding_height": riding_height,
        "strain": -strain,
    }
    return gain - price, terms
