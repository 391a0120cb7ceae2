"""Bodies and evaluations in words, as they stand in prompts."""

from __future__ import annotations

from collections.abc import Sequence

from robomore.tasks.task import Task
from robomore.types import Evaluation, Morphology, Reward, Status

_LONGEST_DIAGNOSIS = 300
_LISTED = 6
"""Results that are listed one by one; more are summed up."""


def body(task: Task, morphology: Morphology) -> list[str]:
    """Return the lines that describe a body: its numbers, and the idea behind them."""
    numbers = ", ".join(
        f"{name} {value:.6g}" for name, value in zip(task.names, morphology.parameters, strict=True)
    )
    return [f"Parameters: {numbers}", *([f"Idea: {morphology.idea}"] if morphology.idea else [])]


def program(reward: Reward) -> list[str]:
    """Return the lines that show a reward."""
    return ["```python", reward.source.strip(), "```"]


def result(evaluation: Evaluation, where: str, full: int = 0) -> list[str]:
    """Return the lines that tell of one evaluation: what it gave, or why it gave nothing.

    Args:
        evaluation: to tell of.
        where: what the first line begins with.
        full: steps of a training to the end; fewer than that are named.
    """
    if not evaluation.ok:
        return [f"{where}: {failure(evaluation)}"]
    lines = [f"{where}: {score(evaluation, full)}"]
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


def results(evaluations: Sequence[Evaluation], where: str, full: int = 0) -> list[str]:
    """Return the lines that sum up several evaluations; those of fewer steps apart from others."""
    failed = [e for e in evaluations if not e.ok]
    lines: list[str] = []
    for steps in sorted({e.job.steps for e in evaluations if e.ok}, reverse=True):
        done = [e for e in evaluations if e.ok and e.job.steps == steps]
        if len(done) <= _LISTED:
            lines += [f"{where}: {score(e, full)}" for e in done]
            continue
        efficiency = _spread([e.efficiency or 0.0 for e in done])
        fitness = _spread([e.fitness or 0.0 for e in done])
        lines.append(
            f"{where}, {len(done)} times{_after(steps, full)}: efficiency {efficiency} 1/m^2, "
            f"fitness {fitness} m"
        )
    if failed:
        reasons = list(dict.fromkeys(failure(e) for e in failed))
        lines.append(f"{where}, {len(failed)} of {len(evaluations)} failed, for example:")
        lines += [f"  {reason}" for reason in reasons[:2]]
    return lines


def score(evaluation: Evaluation, full: int = 0) -> str:
    """Return efficiency with fitness and volume beside it, and the steps if fewer than `full`."""
    efficiency, fitness, volume = (
        "unknown" if value is None else f"{value:.4g}"
        for value in (evaluation.efficiency, evaluation.fitness, evaluation.volume)
    )
    return (
        f"efficiency {efficiency} 1/m^2 (fitness {fitness} m, volume {volume} m^3)"
        f"{_after(evaluation.job.steps, full)}"
    )


def failure(evaluation: Evaluation) -> str:
    """Return why an evaluation gave nothing, in one line."""
    if evaluation.status is Status.FAILED:
        # The diagnosis is a traceback with this machine's file names, and tells a designer nothing.
        return "failed for a reason that has nothing to do with the design"
    said = " ".join(evaluation.diagnosis.split())
    if len(said) > _LONGEST_DIAGNOSIS:
        said = said[:_LONGEST_DIAGNOSIS] + "…"
    return f"failed ({evaluation.status.value}): {said}"


def _after(steps: int, full: int) -> str:
    return f" after only {steps:,} of {full:,} training steps" if steps < full else ""


def _spread(values: list[float]) -> str:
    values = sorted(values)
    return f"{values[0]:.4g} to {values[-1]:.4g}, median {values[len(values) // 2]:.4g}"
