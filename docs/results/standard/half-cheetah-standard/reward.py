# Composed without an LLM, from: forward_speed 3.2, effort 0.032, wobble 0.016 (sum).
import numpy as np


def _get_rew(self, x_velocity, action):
    """Run fast; little effort; steady torso."""
    # Forward speed, in m/s, is what the task is about.
    forward_speed = 3.2 * x_velocity

    # Squared torques, summed over the motors.
    effort = 0.032 * np.sum(np.square(action))

    # Squared turning rate of the torso, in (rad/s)², up to a limit.
    wobble = 0.016 * np.minimum(self.data.qvel[2] ** 2, 25.0)

    reward = forward_speed - effort - wobble
    terms = {
        "forward_speed": forward_speed,
        "effort": -effort,
        "wobble": -wobble,
    }
    return reward, terms
