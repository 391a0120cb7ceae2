# Composed without an LLM, from: upward_speed 5.5, alive 0.15, whole_range 0.12, wobble 0.01 (balance).
import numpy as np


def _get_rew(self, x_velocity, action):
    """Move upward; stay healthy; wide joint motion; steady torso."""
    # Vertical speed of the torso, in m/s.
    upward_speed = 5.5 * self.data.qvel[2]

    # A bonus for every step in which the robot has not fallen.
    alive = 0.15 * float(self.is_healthy)

    # Spread of the joint angles, in rad.
    whole_range = 0.12 * np.tanh(np.std(self.data.qpos[[13, 14, 7, 8, 9, 10, 11, 12]]))

    # Squared turning rate of the torso, in (rad/s)², up to a limit.
    wobble = 0.01 * np.minimum(np.sum(np.square(self.data.qvel[3:6])), 25.0)

    gain = upward_speed + alive + whole_range
    price = wobble
    terms = {
        "upward_speed": upward_speed,
        "alive": alive,
        "whole_range": whole_range,
        "wobble": -wobble,
    }
    return gain - price, terms
