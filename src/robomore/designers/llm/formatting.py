"""Morphologies, rewards and evaluations as lines of a prompt."""

from __future__ import annotations

from collections.abc import Sequence

from robomore.tasks.task import Task
from robomore.types import Evaluation, Morphology, Reward, Status

_LONGEST_DIAGNOSIS = 300
_MOST_SINGLE_RESULTS = 6
"""Results that are listed one by one. More results are summarized."""


def morphology_lines(task: Task, morphology: Morphology) -> list[str]:
    """Return the parameter values of a morphology, and its idea if there is one."""
    named = zip(task.names, morphology.parameters, strict=True)
    lines = ["Parameters: " + ", ".join(f"{name} {value:.6g}" for name, value in named)]
    return [*lines, f"Idea: {morphology.idea}"] if morphology.idea else lines


def reward_lines(reward: Reward) -> list[str]:
    """Return the program text of a reward between fences."""
    return ["```python", reward.source.strip(), "```"]


def evaluation_lines(evaluation: Evaluation, label: str, full: int = 0) -> list[str]:
    """Return all that an evaluation measured, or why it failed. The first line starts with `label`.

    An evaluation with fewer training steps than `full` says so.
    """
    if not evaluation.ok:
        return [f"{label}: {failure(evaluation)}"]
    lines = [f"{label}: {score(evaluation, full)}"]
    if evaluation.behaviour:
        moved = ", ".join(f"{name} {value:.4g}" for name, value in evaluation.behaviour.items())
        lines.append(f"  How it moved: {moved}")
    if evaluation.terms:
        terms = ", ".join(
            f"{name} {term.mean:.4g} ({term.low:.4g} to {term.high:.4g})"
            for name, term in evaluation.terms.items()
        )
        lines.append(f"  Reward terms over training, mean (range): {terms}")
    return lines


def summary_lines(evaluations: Sequence[Evaluation], label: str, full: int = 0) -> list[str]:
    """Return a summary of several evaluations, separately for each number of training steps."""
    failed = [e for e in evaluations if not e.ok]
    lines: list[str] = []
    for steps in sorted({e.job.steps for e in evaluations if e.ok}, reverse=True):
        done = [e for e in evaluations if e.ok and e.job.steps == steps]
        if len(done) <= _MOST_SINGLE_RESULTS:
            lines += [f"{label}: {score(e, full)}" for e in done]
            continue
        efficiency = _range([e.efficiency or 0.0 for e in done])
        fitness = _range([e.fitness or 0.0 for e in done])
        lines.append(
            f"{label}, {len(done)} times{_after(steps, full)}: efficiency {efficiency} m/m³, "
            f"fitness {fitness} m"
        )
    if failed:
        reasons = list(dict.fromkeys(failure(e) for e in failed))
        lines.append(f"{label}, {len(failed)} of {len(evaluations)} failed, for example:")
        lines += [f"  {reason}" for reason in reasons[:2]]
    return lines


def score(evaluation: Evaluation, full: int = 0) -> str:
    """Return efficiency, fitness and volume in words, and the steps if they are below `full`."""
    efficiency, fitness, volume = (
        "unknown" if value is None else f"{value:.4g}"
        for value in (evaluation.efficiency, evaluation.fitness, evaluation.volume)
    )
    return (
        f"efficiency {efficiency} m/m³ (fitness {fitness} m, volume {volume} m³)"
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


def _range(values: list[float]) -> str:
    values = sorted(values)
    return f"{values[0]:.4g} to {values[-1]:.4g}, median {values[len(values) // 2]:.4g}"
