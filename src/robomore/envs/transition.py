"""What a control step of many simulations gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(slots=True)
class Transition:
    """What one control step of all simulations gave; finished ones have been reset already.

    Attributes:
        observation: (num_envs, observation_size) float64, after a reset where an episode ended.
        reward: (num_envs,) float64.
        terminated: (num_envs,) bool, the episode ended because the robot is unhealthy.
        truncated: (num_envs,) bool, the episode ended because its time was up.
        final_observation: (num_envs, observation_size) float64, before any reset: what to
            bootstrap from.
    """

    observation: NDArray[np.float64]
    reward: NDArray[np.float64]
    terminated: NDArray[np.bool_]
    truncated: NDArray[np.bool_]
    final_observation: NDArray[np.float64]
