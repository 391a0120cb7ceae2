"""The designer without a language model: a prior and a surrogate model, and standard terms."""

from __future__ import annotations

from collections.abc import Sequence

from robomore.designers.offline.morphology_optimizer import MorphologyOptimizer
from robomore.designers.offline.morphology_sampler import MorphologySampler
from robomore.designers.offline.reward_optimizer import RewardOptimizer
from robomore.designers.offline.reward_sampler import RewardSampler
from robomore.tasks.task import Task
from robomore.types import Evaluation, Morphology, Reward, Slot, finished


class OfflineDesigner:
    """Designs with numbers and a library of reward terms, without a key and a network.

    Morphologies: a pool of plausible morphologies covers the task's bounds, and each proposal is a
    good one far from the earlier ones. Improvements maximize the expected improvement under a
    Gaussian process of log fitness; the volume is known. Rewards: each proposal is composed of
    terms that the earlier ones lack. Improvements correct what the evaluations show, combine
    rewards, or change something at random.

    The designer sees only what a language model would be shown: of the reference design, what the
    search has among its evaluations.

    Args:
        task: the task to design for.
        seed: seed of the run. The random state of a proposal follows from the seed and the slot.
        objective: what the search compares, `efficiency` or `fitness`.
    """

    name = "offline"
    reflects = True
    provenance = (
        "No LLM was used: morphologies come from a space-filling prior and a Gaussian process, "
        "rewards from a library of terms."
    )

    def __init__(self, task: Task, seed: int, objective: str = "efficiency") -> None:
        self._morphology_sampler = MorphologySampler(task, seed)
        self._reward_sampler = RewardSampler(task, seed)
        self._morphology_optimizer = MorphologyOptimizer(task, seed, objective)
        self._reward_optimizer = RewardOptimizer(task, seed, objective)

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        """Return a plausible morphology far from all `earlier` ones."""
        return self._morphology_sampler.sample(slot, earlier)

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        """Return a reasonable reward with other terms than the `earlier` ones."""
        return self._reward_sampler.sample(slot, earlier)

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        """Return the morphology near `best`'s that promises the largest improvement."""
        return self._morphology_optimizer.improve(slot, best, finished(history))

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        """Return `best`'s reward with one change that the evaluations suggest."""
        return self._reward_optimizer.improve(slot, best, finished(history))
