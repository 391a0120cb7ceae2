"""Short and long legs, each rewarded for rolling and for jumping (paper, Appendix "Motivation").

The paper does not print its two robots nor its rewards. These robots have the volumes that follow
from the paper's numbers, and the rewards are the reference reward and one term more.
"""

from __future__ import annotations

from functools import partial
from statistics import fmean

from robomore.runs.words import label
from robomore.studies.retraining import GIVEN
from robomore.studies.study import Arm, Draw, Results, Study
from robomore.studies.table import Entry, Table
from robomore.tasks.ant import ANT, ANT_REWARD
from robomore.visualize.studies import episodes

SHORT = (0.388, 0.1, 0.1, 0.1, 0.1, 0.26, 0.26, 0.1, 0.1, 0.1)
"""A bulky torso near the ground."""
LONG = (0.132, 0.15, 0.15, 0.4, 0.4, 0.8, 0.8, 0.035, 0.035, 0.035)
"""A small torso high above it."""

_RETURN = "    reward = (forward + healthy) - (effort + contact)\n"
_ROLLING = """    turning = self.data.xmat[1].reshape(3, 3) @ self.data.qvel[3:6]
    rolling = 0.5 * min(max(turning[1], -5.0), 5.0)
    reward = (forward + healthy) - (effort + contact) + rolling
"""
_JUMPING = """    jumping = 0.5 * abs(self.data.qvel[2])
    reward = (forward + healthy) - (effort + contact) + jumping
"""
ROLLING = ANT_REWARD.replace(_RETURN, _ROLLING)
JUMPING = ANT_REWARD.replace(_RETURN, _JUMPING)

PAPER = {
    "short-rolling": (108.83, 288.76),
    "short-jumping": (37.39, 109.50),
    "long-jumping": (59.94, 1457.65),
    "long-rolling": (5.13, 124.75),
}
"""The paper's fitness in m and efficiency in m/m³, cases (a) to (d)."""


def _arm(name: str, parameters: tuple[float, ...], reward: str) -> Arm:
    options = {"parameters": list(parameters), "reward": reward}
    return Arm(name, {"method": GIVEN, "method_options": options})


def _tables(results: Results) -> list[Table]:
    rows: list[tuple[Entry, ...]] = []
    for arm in results.arms:
        designs = [run.found for run in results.runs(ANT.id, arm) if run.found]
        fitness = [one.fitness.mean for one in designs if one.fitness]
        efficiency = [one.efficiency.mean for one in designs if one.efficiency]
        paper_fitness, paper_efficiency = PAPER.get(arm, (None, None))
        rows.append(
            (
                arm,
                fmean(fitness) if fitness else None,
                fmean(efficiency) if efficiency else None,
                designs[0].volume if designs else None,
                paper_fitness,
                paper_efficiency,
                len(fitness),
            )
        )
    return [
        Table(
            "motivation",
            "Two robots, each rewarded for two ways to move",
            (
                *("case", "fitness (m)", "efficiency (m/m³)", "volume (m³)"),
                *("fitness, paper (m)", "efficiency, paper (m/m³)", "runs"),
            ),
            tuple(rows),
            "The paper prints neither its robots nor its rewards: ours have the volumes that "
            "follow from its numbers.",
        )
    ]


def _figures(results: Results) -> dict[str, Draw]:
    lines = {
        arm: values
        for arm in results.arms
        if (
            values := [
                value
                for run in results.runs(ANT.id, arm)
                if run.found
                for evaluation in run.found.trained
                for value in evaluation.episode_fitness
            ]
        )
    }
    return (
        {"motivation": partial(episodes, lines, label("fitness", ANT.goal.unit))} if lines else {}
    )


MOTIVATION = Study(
    name="motivation",
    summary="an Ant with short and one with long legs, each rewarded for rolling and for jumping",
    arms=(
        _arm("short-rolling", SHORT, ROLLING),
        _arm("short-jumping", SHORT, JUMPING),
        _arm("long-jumping", LONG, JUMPING),
        _arm("long-rolling", LONG, ROLLING),
    ),
    tables=_tables,
    figures=_figures,
    tasks=(ANT.id,),
)
