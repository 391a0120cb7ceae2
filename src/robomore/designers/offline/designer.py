"""The designer without an LLM: bodies from a prior and a model, rewards from the field's terms."""

from __future__ import annotations

from collections.abc import Sequence

from robomore.designers.offline.morphology_optimizer import MorphologyOptimizer
from robomore.designers.offline.morphology_sampler import MorphologySampler
from robomore.designers.offline.reward_optimizer import RewardOptimizer
from robomore.designers.offline.reward_sampler import RewardSampler
from robomore.tasks.task import Task
from robomore.types import Evaluation, Morphology, Reward, Slot, finished


class OfflineDesigner:
    """Designs with numbers and a library of reward terms; needs no key and no network.

    Bodies: a pool of believable bodies spread over the task's bounds, from which each proposal
    takes the best and farthest one; improved by expected improvement under a Gaussian process of
    log fitness, the volume being known. Rewards: composed from the field's terms, each unlike the
    earlier ones; improved by curing what the measurements show, by recombination and by trial.

    It never sees the official robot's numbers or reward: only what an LLM would be shown.

    Args:
        task: what to design for.
        seed: the run's; each proposal's random state follows from it and from the slot.
        objective: `efficiency` or `fitness`, what the search compares.
    """

    name = "offline"
    reflects = True
    provenance = (
        "No LLM was used: bodies come from a space-filling prior and a Gaussian process, rewards "
        "from a library of terms."
    )

    def __init__(self, task: Task, seed: int, objective: str = "efficiency") -> None:
        self._bodies = MorphologySampler(task, seed)
        self._rewards = RewardSampler(task, seed)
        self._refiner = MorphologyOptimizer(task, seed, objective)
        self._reweigher = RewardOptimizer(task, seed, objective)

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        """Return a believable body far from all `earlier` ones."""
        return self._bodies.propose(slot, earlier)

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        """Return a sane reward made of other terms than the `earlier` ones."""
        return self._rewards.propose(slot, earlier)

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        """Return the body near `best`'s that the model expects most of."""
        return self._refiner.improve(slot, best, finished(history))

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        """Return `best`'s reward with one change that the measurements speak for."""
        return self._reweigher.improve(slot, best, finished(history))
