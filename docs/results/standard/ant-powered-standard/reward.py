# Composed without an LLM, from: sprint 2.6, alive 0.24, effort 0.032 (sum).
import numpy as np


def _get_rew(self, x_velocity, action):
    """Run fast, with increasing returns; stay healthy; little effort."""
    # The reward grows faster than the speed, so slow motion is not enough.
    sprint = 2.6 * x_velocity * (1.0 + 0.1 * np.abs(x_velocity))

    # A bonus for every step in which the robot has not fallen.
    alive = 0.24 * float(self.is_healthy)

    # Squared torques, summed over the motors.
    effort = 0.032 * np.sum(np.square(action))

    reward = sprint + alive - effort
    terms = {
        "sprint": sprint,
        "alive": alive,
        "effort": -effort,
    }
    return reward, terms
