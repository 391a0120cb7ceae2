# Composed without an LLM, from: forward_speed 3.2, effort 0.032 (sum).
import numpy as np


def _get_rew(self, x_velocity, action):
    """Run fast; little effort."""
    # Forward speed, in m/s, is what the task is about.
    forward_speed = 3.2 * x_velocity

    # Squared torques, summed over the motors.
    effort = 0.032 * np.sum(np.square(action))

    reward = forward_speed - effort
    terms = {
        "forward_speed": forward_speed,
        "effort": -effort,
    }
    return reward, terms
