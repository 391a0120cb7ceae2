"""The human baseline: the official robot and the official reward, as a designer like any other."""

from __future__ import annotations

from collections.abc import Sequence

from robomore.tasks.task import Task
from robomore.types import Evaluation, Morphology, Reward, Slot


class HumanDesigner:
    """Returns the task's reference body and reference reward, whatever it is asked for.

    A grid of one body and one reward is the paper's "Human" row. More of the same design costs
    nothing, because an evaluation that is known is looked up; and an improvement that is the same
    design again does not improve, so the fine stage ends after one cycle.
    """

    name = "human"
    reflects = False
    provenance = "No LLM was used: the official robot and the official reward, made by people."

    def __init__(self, task: Task) -> None:
        self._morphology = Morphology(task.reference, "the official robot")
        self._reward = Reward(task.reward, "the official reward")

    def propose_morphology(self, slot: Slot, earlier: Sequence[Morphology]) -> Morphology:
        """Return the official robot."""
        return self._morphology

    def propose_reward(self, slot: Slot, earlier: Sequence[Reward]) -> Reward:
        """Return the official reward."""
        return self._reward

    def improve_morphology(
        self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]
    ) -> Morphology:
        """Return the official robot again."""
        return self._morphology

    def improve_reward(self, slot: Slot, best: Evaluation, history: Sequence[Evaluation]) -> Reward:
        """Return the official reward again."""
        return self._reward
