"""Morphologies, rewards and evaluations as lines of a prompt."""

from __future__ import annotations

import re
from statistics import stdev

from robomore.designers.llm.objectives import OBJECTIVES
from robomore.tasks.fitness import Fitness
from robomore.tasks.task import Task
from robomore.types import Curve, Evaluation, Morphology, Reward, Status

_LONGEST_DIAGNOSIS = 300
_CURVE_POINTS = (0.1, 0.25, 0.5, 0.75, 1.0)
"""Parts of the training at which a learning curve is shown."""


def morphology_lines(task: Task, morphology: Morphology) -> list[str]:
    """Return the parameter values of a morphology, and its idea if there is one."""
    named = zip(task.names, morphology.parameters, strict=True)
    lines = ["Parameters: " + ", ".join(f"{name} {value:.6g}" for name, value in named)]
    return [*lines, f"Idea: {morphology.idea}"] if morphology.idea else lines


def reward_lines(reward: Reward) -> list[str]:
    """Return the program text of a reward between fences that it does not hold itself."""
    longest = max(map(len, re.findall("`+", reward.source)), default=0)
    fence = "`" * max(3, longest + 1)
    return [f"{fence}python", reward.source.strip(), fence]


def evaluation_lines(
    evaluation: Evaluation,
    label: str,
    goal: Fitness,
    objective: str,
    full: int = 0,
    curve: Curve | None = None,
) -> list[str]:
    """Return all that an evaluation measured, or why it failed. The first line starts with `label`.

    `goal` is the task's, `objective` what the search compares. An evaluation with fewer training
    steps than `full` says so. `curve` is its learning curve.
    """
    if not evaluation.ok:
        return [f"{label}: {failure(evaluation)}"]
    lines = [f"{label}: {score(evaluation, goal, objective, full)}"]
    if evaluation.behaviour:
        moved = ", ".join(f"{name} {value:.4g}" for name, value in evaluation.behaviour.items())
        lines.append(f"  How it moved: {moved}")
    if evaluation.terms:
        terms = ", ".join(
            f"{name} {term.mean:.4g} ({term.low:.4g} to {term.high:.4g})"
            for name, term in evaluation.terms.items()
        )
        lines.append(f"  Reward terms over training, mean (range): {terms}")
    if curve is not None and (line := curve_line(curve)):
        lines.append(line)
    return lines


def curve_line(curve: Curve) -> str:
    """Return a few points of a learning curve in one line."""
    last = len(curve.steps) - 1
    points = sorted({round(share * last) for share in _CURVE_POINTS})
    said = []
    for name, words in (
        ("episode_return", "return of an episode"),
        ("episode_length", "its length in control steps"),
    ):
        series = curve.series.get(name, ())
        values = [(curve.steps[i], series[i]) for i in points if i < len(series)]
        shown = [f"{value:.4g} at {steps:,}" for steps, value in values if value is not None]
        if shown:
            said.append(f"{words} " + ", ".join(shown))
    return f"  Learning curve by training steps: {'; '.join(said)}" if said else ""


def score(evaluation: Evaluation, goal: Fitness, objective: str, full: int = 0) -> str:
    """Return efficiency, fitness and volume in words, after the score if it is neither of these.

    The steps of training follow if they are below `full`.
    """
    own, efficiency, fitness, volume = (
        "unknown" if value is None else f"{value:.4g}"
        for value in (
            evaluation.score(objective),
            *(evaluation.efficiency, evaluation.fitness, evaluation.volume),
        )
    )
    first = (
        "" if objective in ("efficiency", "fitness") else f"{OBJECTIVES[objective].name} {own}, "
    )
    episodes = evaluation.episode_fitness
    # The spread is that over the episodes of one trained policy.
    spread = f" ± {stdev(episodes):.2g}" if len(episodes) > 1 else ""
    return (
        f"{first}efficiency {efficiency} {goal.per_volume} "
        f"({f'fitness {fitness}{spread} {goal.unit}'.rstrip()}, volume {volume} m³)"
        f"{_after(evaluation.job.steps, full)}"
    )


def failure(evaluation: Evaluation) -> str:
    """Return in one line why an evaluation failed."""
    if evaluation.status is Status.FAILED:
        # This diagnosis is a traceback with file names of this machine. It helps no designer.
        return "failed for a reason that has nothing to do with the design"
    diagnosis = " ".join(evaluation.diagnosis.split())
    if len(diagnosis) > _LONGEST_DIAGNOSIS:
        diagnosis = diagnosis[:_LONGEST_DIAGNOSIS] + "…"
    return f"failed ({evaluation.status.value}): {diagnosis}"


def _after(steps: int, full: int) -> str:
    return f" after only {steps:,} of {full:,} training steps" if steps < full else ""
