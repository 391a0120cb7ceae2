"""`robomore show --json`: a run as plain data, for scripts to rely on (docs/runs.md)."""

from __future__ import annotations

from typing import Any

from robomore.runs import Run, Spread, TrainedDesign
from robomore.runs.audits import audit_of
from robomore.runs.lineage import Record


def as_data(run: Run) -> dict[str, Any]:
    """Return a run as JSON data. Keys and units stand in docs/runs.md, "JSON of a run"."""
    manifest, cost, spending = run.manifest, run.cost, run.spending
    audit = audit_of(run)
    method = manifest.settings.method
    return {
        "run": str(run.folder),
        "task": manifest.task,
        "preset": manifest.preset,
        "method": {"name": method.name, "options": method.options},
        "designer": manifest.designer,
        "provenance": manifest.provenance,
        "seed": manifest.seed,
        "objective": run.objective,
        "budget_steps": run.budget_steps,
        "plan": [
            {
                "name": stage.name,
                "role": stage.role,
                "axes": list(stage.axes),
                "shape": list(stage.shape),
                "evaluations": stage.evaluations,
                "steps": stage.steps,
            }
            for stage in run.plan.stages
        ],
        "fitness": {
            "name": run.task.goal.name,
            "unit": run.fitness_unit,
            "unit_per_volume": run.task.goal.per_volume,
        },
        "starts": [start.origin for start in run.manifest.starts],
        # Of the run, also where one evaluation stands in the champion's place.
        "final": run.found is not None,
        "evaluation": run.focus,
        "champion_role": run.champion_role,
        "champion": _group(run.champion, run.objective),
        "found": _group(run.found, run.objective),
        "reference": _group(run.reference, run.objective),
        "morphology_only": _group(run.morphology_only, run.objective),
        "reward_only": _group(run.reward_only, run.objective),
        "audit": audit.as_data() if audit else None,
        "verdict": run.pairs.verdict if run.pairs else "",
        "ratio": {
            "objective": _spread(run.ratio),
            "efficiency": _spread(run.efficiency_ratio),
            "fitness": _spread(run.fitness_ratio),
        },
        "evaluations": {str(status): count for status, count in run.counts.items()},
        "cost": {
            "evaluations": cost.evaluations,
            "steps": cost.steps,
            "search_steps": run.search_steps,
            "core_seconds": cost.core_seconds,
            "requests": spending.requests,
            "tokens": spending.tokens,
            "dollars": None if spending.unpriced else spending.cost,
        },
        "lineage": [_step(record, run) for record in run.lineage],
        "failures": [
            {
                "status": str(failure.status),
                "diagnosis": failure.diagnosis,
                "count": len(failure.places),
                "places": [run.plan.describe(place) for place in failure.places],
            }
            for failure in run.failures
        ],
        "empty_slots": [{"slot": str(one.slot), "reason": one.reason} for one in run.empty],
        "passed_over": list(run.passed_over),
        "warnings": list(run.warnings),
        "task_changes": list(run.task_changes),
        "versions": manifest.versions,
    }


def _group(one: TrainedDesign | None, objective: str) -> dict[str, Any] | None:
    if one is None:
        return None
    design, job = one.design, one.evaluations[0].job
    return {
        "parameters": one.parameters,
        "reward": design.reward.source,
        "ideas": {"morphology": design.morphology.idea, "reward": design.reward.idea},
        "score": _spread(one.score(objective)),
        "fitness": _spread(one.fitness),
        "volume": one.volume,
        "efficiency": _spread(one.efficiency),
        "body": one.body,
        "behaviour": one.behaviour,
        "steps": job.steps,
        "episodes": job.episodes,
        "evaluations": [
            {
                "key": evaluation.key,
                "seed": evaluation.job.seed,
                "status": str(evaluation.status),
                "diagnosis": evaluation.diagnosis,
                "score": evaluation.score(objective),
                "fitness": evaluation.fitness,
                "efficiency": evaluation.efficiency,
            }
            for evaluation in one.evaluations
        ],
    }


def _spread(measured: Spread | None) -> dict[str, Any] | None:
    if measured is None:
        return None
    return {
        "mean": measured.mean,
        "interval": list(measured.interval) if measured.interval else None,
        "values": list(measured.values),
    }


def _step(record: Record, run: Run) -> dict[str, Any]:
    place, evaluation = record.place, record.evaluation
    return {
        "place": run.plan.describe(place),
        "stage": place.stage,
        "index": list(place.index),
        "changed": place.changed,
        "key": evaluation.key,
        "parent": place.parent,
        "score": evaluation.score(run.objective),
        "fitness": evaluation.fitness,
        "volume": evaluation.volume,
        "efficiency": evaluation.efficiency,
    }
