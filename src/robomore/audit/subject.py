"""What is audited: a robot and its policy, measured again and again, each way once."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robomore.audit.inspection import Inspection, inspect
from robomore.audit.variant import PLAIN, NoisyPolicy, Variant, VariedEnv, WatchedPolicy
from robomore.envs.compile import body_facts
from robomore.errors import TrainingDiverged, UnstableSimulation
from robomore.evaluation.measure import FinitePolicy, Measurement, measure_in
from robomore.identity import derive_seed
from robomore.tasks.task import Task
from robomore.training.policy import MLPPolicy

EPISODES = 5
"""Of each measurement. All of them use the same seeds, so that two differ by the change alone."""
_INSPECTED = 2
"""Episodes that are looked into step by step, which costs more."""


@dataclass
class Subject:
    """A design with the policy that was kept.

    Attributes:
        task: what it was trained for.
        parameters: of the morphology, in the task's order.
        policy: that was kept.
        reported: fitness that the run tells; `None` where none is told.
        seed: of the audit's episodes, which no measurement of a run uses.
        episodes: of each measurement.
    """

    task: Task
    parameters: tuple[float, ...]
    policy: MLPPolicy
    reported: float | None = None
    seed: int = 0
    episodes: int = EPISODES
    _measured: dict[Variant, Measurement | None] = field(
        default_factory=dict, init=False, repr=False
    )
    _spread: NDArray[np.float64] | None = field(default=None, init=False, repr=False)

    @property
    def seeds(self) -> list[int]:
        """One for each episode."""
        return [derive_seed(self.seed, "audit", index) for index in range(self.episodes)]

    def measured(self, variant: Variant = PLAIN) -> Measurement | None:
        """Return what the policy is worth under `variant`; `None` where it cannot be measured."""
        if variant not in self._measured:
            if variant != PLAIN:
                self.measured()  # says how far observations spread
            self._measured[variant] = self._measure(variant)
        return self._measured[variant]

    def worth(self, variant: Variant = PLAIN) -> float | None:
        """Return the fitness; of a jump the height above its rest; `None` as above.

        The fitness of a jumping task counts the height that the robot has at rest. A check that
        asks how much is lost must not.
        """
        found = self.measured(variant)
        if found is None:
            return None
        jumps = self.task.goal.name == "height"
        return found.behaviour["height_gain_m"] if jumps else found.fitness

    @property
    def unit(self) -> str:
        """Unit of what the robot is worth."""
        return self.task.goal.unit

    @cached_property
    def inspection(self) -> Inspection | None:
        """What was seen inside the simulation as it is; `None` where the physics diverges."""
        try:
            return inspect(self.task, self.parameters, self._finite, self.seeds[:_INSPECTED])
        except (TrainingDiverged, UnstableSimulation):
            return None

    @property
    def has_ground(self) -> bool:
        """Whether anything in this task touches a ground."""
        return self.inspection is None or self.inspection.has_ground

    @cached_property
    def facts(self) -> dict[str, float]:
        """Volume, mass, density and rest height of the robot."""
        return body_facts(self.task, self.parameters)

    @cached_property
    def reference_facts(self) -> dict[str, float]:
        """The same of the task's reference morphology."""
        return body_facts(self.task, self.task.reference)

    @property
    def _finite(self) -> FinitePolicy:
        return FinitePolicy(self.policy.weights, self.policy.biases)

    def _measure(self, variant: Variant) -> Measurement | None:
        env = VariedEnv(self.task, self.parameters, self.episodes, variant)
        try:
            if variant == PLAIN:
                watched = WatchedPolicy(self._finite)
                found = measure_in(env, self.task, watched, self.seeds)
                self._spread = watched.spread
                return found
            if variant.observation_noise or variant.action_noise:
                spread = self._spread if self._spread is not None else np.zeros(1)
                noisy = NoisyPolicy(self._finite, variant, spread, self.seed)
                return measure_in(env, self.task, noisy, self.seeds)
            return measure_in(env, self.task, self._finite, self.seeds)
        except (TrainingDiverged, UnstableSimulation):
            return None
