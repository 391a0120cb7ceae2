# Composed without an LLM, from: early_progress 4, alive 0.45, upright 0.23, joint_speed 0.0029, off_course 0.1 (balance).
import numpy as np


def _get_rew(self, x_velocity, action):
    """Start to move, with diminishing returns; stay healthy; upright torso; slow joints; stay on the course."""
    # The first metre per second is worth the most, so that learning starts early.
    early_progress = 4 * np.sign(x_velocity) * np.log1p(np.abs(x_velocity))

    # A bonus for every step in which the robot has not fallen.
    alive = 0.45 * float(self.is_healthy)

    # 1 when the torso is as upright as at the start, -1 upside down.
    upright = 0.23 * (1 - 2 * (self.data.qpos[4] ** 2 + self.data.qpos[5] ** 2))

    # Squared joint speeds.
    joint_speed = 0.0029 * np.mean(np.square(self.data.qvel[[12, 13, 6, 7, 8, 9, 10, 11]]))

    # Distance from the straight course, in m, up to a limit.
    off_course = 0.1 * np.minimum(np.abs(self.data.qpos[1]), 3.0)

    gain = early_progress + alive + upright
    price = joint_speed + off_course
    terms = {
        "early_progress": early_progress,
        "alive": alive,
        "upright": upright,
        "joint_speed": -joint_speed,
        "off_course": -off_course,
    }
    return gain - price, terms
