"""Swimmers, rewards and evaluations for tests of the LLM designer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from designers import evaluations
from robomore.tasks import Task, get_task
from robomore.types import Evaluation, Morphology, Reward, Status, TermStatistics

_BOUNDS = {"length": (0.05, 3.0), "radius": (0.005, 0.3)}
SWIMMER = replace(
    get_task("swimmer"),
    parameters=tuple(
        replace(p, low=low, high=high)
        for p in get_task("swimmer").parameters
        for low, high in (_BOUNDS[p.name.split("_")[1]],)
    ),
    rules=(),
)
"""The swimmer with bounds that stay as they are."""


def body(*values: float, idea: str = "") -> Morphology:
    """A swimmer; missing numbers are those of a plain one."""
    plain = (0.4, 0.5, 0.6, 0.02, 0.03, 0.04)
    return Morphology((*values, *plain[len(values) :]), idea)


def reward(weight: float = 1.0, lines: int = 0) -> Reward:
    """A reward whose length grows with `lines`."""
    filler = "".join(f"    unused_{weight:g}_{i} = {i}\n" for i in range(lines)).replace(".", "_")
    return Reward(
        "def _get_rew(self, x_velocity, action):\n"
        f'    """Speed, {weight:g} times."""\n{filler}'
        f'    return {weight:g} * x_velocity, {{"speed": {weight:g} * x_velocity}}\n',
        f"Speed, {weight:g} times.",
    )


def evaluation(
    morphology: Morphology,
    program: Reward,
    fitness: float | None,
    diagnosis: str = "line 3: division by zero",
    task: Task = SWIMMER,
) -> Evaluation:
    """Return a success with `fitness`, or a failure with `diagnosis`."""
    if fitness is None:
        return evaluations.evaluation(
            task, morphology, program, status=Status.REWARD_FAILED, diagnosis=diagnosis
        )
    return evaluations.evaluation(
        task,
        morphology,
        program,
        fitness,
        behaviour={"mean_speed_m_per_s": fitness / 50, "mean_height_m": 0.25},
        terms={"speed": TermStatistics(0.5, -0.25, 1.75)},
    )


def grid(bodies: Sequence[Morphology], rewards: Sequence[Reward]) -> list[Evaluation]:
    """All pairs, better with each body and reward."""
    return [
        evaluation(b, r, 1.0 + 10 * i + j)
        for i, b in enumerate(bodies)
        for j, r in enumerate(rewards)
    ]
