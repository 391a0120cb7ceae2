# Composed without an LLM, from: early_progress 4.2, alive 0.4, upright 0.37, riding_height 0.36, strain 0.13, joint_speed 0.0044 (table).
import numpy as np


def _get_rew(self, x_velocity, action):
    """Start to move, with diminishing returns; stay healthy; upright torso; constant torso height; little mean torque; slow joints."""
    # The first metre per second is worth the most, so that learning starts early.
    early_progress = 4.2 * np.sign(x_velocity) * np.log1p(np.abs(x_velocity))

    # A bonus for every step in which the robot has not fallen.
    alive = 0.4 * float(self.is_healthy)

    # 1 when the torso is as upright as at the start, -1 upside down.
    upright = 0.37 * (np.cos(self.data.qpos[2]))

    # Keeps the torso near its starting height.
    riding_height = 0.36 * np.exp(-8.0 * np.square(self.data.qpos[1] - self.init_qpos[1]))

    # Mean absolute torque.
    strain = 0.13 * np.mean(np.abs(action))

    # Squared joint speeds.
    joint_speed = 0.0044 * np.mean(np.square(self.data.qvel[3:9]))

    terms = {
        "early_progress": early_progress,
        "alive": alive,
        "upright": upright,
        "riding_height": riding_height,
        "strain": -strain,
        "joint_speed": -joint_speed,
    }
    return sum(terms.values()), terms
