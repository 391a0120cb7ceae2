"""The paper's "Random Sample": bodies drawn from a Gaussian around the official robot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robomore.designers.offline.space import UnitSpace
from robomore.errors import InputError, ProposalFailed
from robomore.identity import derive_seed
from robomore.tasks.task import Task
from robomore.types import Evaluation, Morphology, Reward, Slot

DRAWS = 2000
"""Bodies drawn before giving up on a valid one."""

LEAST_SHARE = 0.1
"""A parameter whose official value is near 0 varies as if it were this share of its range."""


class RandomDesigner:
    """Draws bodies; the reward is always the official one. Learns nothing from what was measured.

    Args:
        task: what to design for.
        seed: the run's.
        deviation: standard deviation of each parameter, as a share of its official value. A half
            gives about the coefficient of variation that the paper reports (Table 3).

    Raises:
        InputError: `deviation` is not positive.
    """

    name = "random"
    reflects = False
    provenance = "No LLM was used: bodies are drawn at random around the official robot."

    def __init__(self, task: Task, seed: int, deviation: float = 0.5) -> None:
        if not deviation > 0:
            raise InputError(f"deviation = {deviation} has to be larger than 0")
        self._task = task
        self._seed = seed
        self._space = UnitSpace(task)
        self._mean = np.array(task.reference)
        self._low = np.array([parameter.low for parameter in task.parameters])
        self._high = np.array([parameter.high for parameter in task.parameters])
        size = np.maximum(np.abs(self._mean), LEAST_SHARE * (self._high - self._low))
        self._deviation = deviation * size

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        """Return a valid draw; `earlier` ones do not matter.

        Raises:
            ProposalFailed: no draw passed the task's rules.
        """
        random = np.random.default_rng(derive_seed(self._seed, "draw", slot))
        for _ in range(DRAWS):
            drawn = np.round(random.normal(self._mean, self._deviation), 5)
            body = np.clip(drawn, self._low, self._high)
            if self._space.valid(body[None])[0]:
                return Morphology(tuple(body.tolist()), "drawn around the official robot")
        raise ProposalFailed(
            f"{self._task.id}: none of {DRAWS} bodies drawn around the official robot is valid"
        )

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        """Return the official reward."""
        return Reward(self._task.reward, "the official reward")

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        """Return another draw."""
        return self.propose_morphology(slot, ())

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        """Return the official reward again: this baseline varies bodies only."""
        return Reward(self._task.reward, "the official reward")
