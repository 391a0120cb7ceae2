"""Reward normalisation: what is learnt does not depend on a reward's unit or offset.

A designer writes a reward in units of its own choice. So rewards are clipped to a range, and states
are valued by how much better than usual they are (as with the mean reward of Naik et al. 2024), in
standard deviations of the discounted returns (as in SimbaV2, Lee et al. 2025). The problem stays
the same one: a termination is given the value that it has on this scale.
"""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

TAIL = 0.005
"""Fraction of all rewards, at either end, that does not count as usual."""

CLIP = 10.0
"""A reward is clipped that lies outside the usual ones by this many times their range."""

SPREAD = 32.0
"""Standard deviation of values on the scale. It was chosen by trying: with 1, Half-Cheetah, Swimmer
and Walker learnt worse, perhaps because Adam's steps do not shrink with what is learnt."""

LARGEST = 1e100
"""Rewards beyond are clipped to it before anything else, so that their sums stay finite."""


@dataclass(frozen=True, slots=True)
class RewardScale:
    """The scale on which critics value states: (value - `usual`) / `unit`.

    A reward times a power of two has this scale times the same power, to the last bit.

    Attributes:
        low, high: range that rewards are clipped to.
        usual: mean value of the states that were seen, in units of the reward.
        unit: standard deviation of these values, divided by `SPREAD`.
    """

    low: float = -math.inf
    high: float = math.inf
    usual: float = 0.0
    unit: float = 1.0

    def normalize(self, reward: NDArray[np.float64], gamma: float) -> NDArray[np.float64]:
        """Return rewards on this scale, of the shape of `reward`.

        Args:
            reward: for one control step each.
            gamma: discount factor for each control step.
        """
        clipped = np.clip(reward, self.low, self.high)
        scaled: NDArray[np.float64] = (clipped - (1 - gamma) * self.usual) / self.unit
        return scaled

    @property
    def value_of_termination(self) -> float:
        """The value, on this scale, of a state after which there are no rewards."""
        return -self.usual / self.unit

    def to_array(self) -> NDArray[np.float64]:
        """Return the numbers, (4,)."""
        return np.array(astuple(self))


def measure_scale(
    reward: NDArray[np.float64],
    ended: NDArray[np.bool_],
    terminated: NDArray[np.bool_],
    gamma: float,
) -> RewardScale:
    """Return the scale of rewards that were seen.

    Args:
        reward: (steps, num_envs), oldest first, within `LARGEST`.
        ended: (steps, num_envs), the episode ended with this step.
        terminated: (steps, num_envs), it ended because the robot was unhealthy.
        gamma: discount factor for each control step.
    """
    least, most = np.quantile(reward, [TAIL, 1 - TAIL]).tolist()
    if least == most:  # nearly all are the same: the others are what matters
        least, most = float(reward.min()), float(reward.max())
    width = most - least
    low, high = least - CLIP * width, most + CLIP * width
    # A power of two in place of the width, so that squares stay finite and bits do not change.
    power = 2.0 ** math.frexp(width or abs(most) or 1.0)[1]
    # Of each step's state: the discounted rewards to the end of what was seen of its episode, and
    # what the value of the state there counts with.
    returns = np.clip(reward, low, high) / power
    rest = gamma * ~terminated
    for step in range(len(returns) - 2, -1, -1):
        goes_on = ~ended[step]
        returns[step] += gamma * goes_on * returns[step + 1]
        rest[step] *= np.where(goes_on, rest[step + 1], 1.0)
    # If the states at those ends are worth what states usually are:
    usual = float(returns.mean() / (1 - rest.mean()))
    values = returns + usual * rest
    # The values of a reward that never changes differ by rounding, or not at all.
    deviation = max(float(values.std()), 1e-6 * float(np.abs(values).max())) or 1.0
    return RewardScale(low, high, usual * power, deviation * power / SPREAD)
