"""`robomore show --json`: a summary as plain data, for scripts to rely on."""

from __future__ import annotations

from typing import Any

from robomore.report.finalists import Contestant
from robomore.report.lineage import Step
from robomore.report.metrics import Spread
from robomore.report.summary import Summary
from robomore.report.words import place_name


def as_data(summary: Summary) -> dict[str, Any]:
    """Return a summary as JSON data; units stand in docs/runs.md.

    `champion` has `parameters` by name, `reward` as text, and the means `fitness` (m), `volume`
    (m^3) and `efficiency` (m/m^3); `spread` holds what stands behind the means.
    """
    manifest = summary.manifest
    return {
        "run": str(summary.folder),
        "task": manifest.task,
        "preset": manifest.preset,
        "designer": manifest.designer,
        "provenance": manifest.provenance,
        "seed": manifest.seed,
        "objective": summary.objective,
        "final": summary.final,
        "champion": _contestant(summary.champion),
        "human": _contestant(summary.human),
        "ratio": {
            "efficiency": _spread(summary.efficiency_ratio),
            "fitness": _spread(summary.fitness_ratio),
        },
        "evaluations": {str(status): count for status, count in summary.counts.items()},
        "cost": {
            "evaluations": summary.cost.evaluations,
            "steps": summary.cost.steps,
            "core_seconds": summary.cost.core_seconds,
            "requests": summary.spending.requests,
            "tokens": summary.spending.tokens,
            "dollars": None if summary.spending.unpriced else summary.spending.cost,
        },
        "way": [_step(step) for step in summary.way],
        "failures": [
            {
                "status": str(failure.status),
                "diagnosis": failure.diagnosis,
                "count": len(failure.places),
                "places": [place_name(place) for place in failure.places],
            }
            for failure in summary.failures
        ],
        "empty_slots": [{"slot": str(one.slot), "reason": one.reason} for one in summary.empty],
        "cautions": list(summary.cautions),
        "versions": manifest.versions,
    }


def _contestant(one: Contestant | None) -> dict[str, Any] | None:
    if one is None:
        return None
    return {
        "parameters": one.parameters,
        "reward": one.design.reward.source,
        "ideas": {
            "morphology": one.design.morphology.idea,
            "reward": one.design.reward.idea,
        },
        "fitness": one.fitness.mean if one.fitness else None,
        "volume": one.volume,
        "efficiency": one.efficiency.mean if one.efficiency else None,
        "spread": {"fitness": _spread(one.fitness), "efficiency": _spread(one.efficiency)},
        "seeds": [evaluation.job.seed for evaluation in one.evaluations],
        "steps": one.evaluations[0].job.steps,
        "episodes": one.evaluations[0].job.episodes,
        "evaluations": [
            {
                "key": evaluation.key,
                "seed": evaluation.job.seed,
                "status": str(evaluation.status),
                "diagnosis": evaluation.diagnosis,
                "fitness": evaluation.fitness,
                "efficiency": evaluation.efficiency,
            }
            for evaluation in one.evaluations
        ],
        "body": one.body,
    }


def _spread(measured: Spread | None) -> dict[str, Any] | None:
    if measured is None:
        return None
    return {
        "mean": measured.mean,
        "std": measured.std,
        "interval": list(measured.interval) if measured.interval else None,
        "values": list(measured.values),
    }


def _step(step: Step) -> dict[str, Any]:
    return {
        "stage": step.place.stage,
        "place": place_name(step.place),
        "changed": step.changed,
        "branch": step.place.branch,
        "cycle": step.place.cycle,
        "efficiency": step.efficiency.mean,
        "fitness": step.fitness.mean,
        "volume": step.evaluation.volume,
        "key": step.evaluation.key,
        "leads_to_champion": step.leads,
    }
