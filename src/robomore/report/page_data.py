"""A run's evaluations as data for the page's scripts: every design that a reader may open."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from robomore.errors import InvalidMorphology
from robomore.runs import Run
from robomore.runs.words import unit_of
from robomore.text import sanitize
from robomore.types import Curve, Evaluation

MOST_STILLS = 600
"""Morphologies that are drawn: each takes some milliseconds to compile."""


def page_data(run: Run, moving: Collection[str], kept: Collection[str]) -> dict[str, Any]:
    """Return what `main.js` reads: evaluations, and the texts and morphologies that they share.

    Args:
        run: whose page it is.
        moving: keys of evaluations that the page shows in motion.
        kept: keys of evaluations whose policies were kept.
    """
    places: dict[str, list[Any]] = {}
    for record in run.records:
        places.setdefault(record.evaluation.key, []).append(record.place)
    cut = {record.evaluation.key for record in run.cut}
    rewards = _numbered(e.design.reward.source for e in run.evaluations)
    morphologies = _numbered(e.design.morphology.parameters for e in run.evaluations)
    evaluations = []
    for number, one in enumerate(run.evaluations):
        first = places[one.key][0]
        evaluations.append(
            _evaluation(one, run.objective)
            | {
                "seconds": _short(run.core_seconds[one.key]),
                "places": [sanitize(run.plan.describe(place)) for place in places[one.key]],
                "stage": sanitize(first.stage),
                "changed": sanitize(first.changed),
                "parent": sanitize(first.parent),
                "final": run.plan.stage(first.stage).role == "final",
                "cut": one.key in cut,
                "replay": one.key in moving,
                "kept": one.key in kept,
                "m": morphologies[one.design.morphology.parameters],
                "r": rewards[one.design.reward.source],
                "curve": number,
            }
        )
    stills, view = _stills(run, morphologies)
    champion = run.champion.best(run.objective).key if run.champion and run.champion.trained else ""
    reference = run.reference
    return {
        "objective": run.objective,
        "unit": unit_of(run.objective, run.fitness_unit),
        "fitnessUnit": run.fitness_unit,
        "perVolume": unit_of("efficiency", run.fitness_unit),
        "parameters": [
            {
                "name": parameter.name,
                "unit": parameter.unit,
                "low": parameter.low,
                "high": parameter.high,
                "reference": parameter.reference,
            }
            for parameter in run.task.parameters
        ],
        "referenceReward": sanitize(run.task.reward),
        "rewards": [sanitize(source) for source in rewards],
        "morphologies": [[_short(value) for value in values] for values in morphologies],
        "stills": stills,
        "undrawn": f"Not drawn: in a run this large only the best {MOST_STILLS} morphologies are.",
        "view": view,
        "evaluations": evaluations,
        "lineage": [record.evaluation.key for record in run.lineage],
        "champion": champion,
        "reference": reference.best(run.objective).key if reference and reference.trained else "",
    }


def curve_data(run: Run) -> list[dict[str, Any] | None]:
    """Return the learning curves of a run's evaluations, in the order of `page_data`."""
    curves = run.curves()
    return [_curve(curves.get(one.key)) for one in run.evaluations]


def _evaluation(one: Evaluation, objective: str) -> dict[str, Any]:
    design = one.design
    return {
        "key": one.key,
        "status": str(one.status),
        "diagnosis": sanitize(one.diagnosis),
        "fitness": _short(one.fitness),
        "volume": _short(one.volume),
        "efficiency": _short(one.efficiency),
        "energy": _short(one.energy),
        "score": _short(one.score(objective)),
        "steps": one.job.steps,
        # JavaScript has no whole numbers as large as a seed may be.
        "seed": str(one.job.seed),
        "ideas": [sanitize(design.morphology.idea), sanitize(design.reward.idea)],
        "notes": [sanitize(note) for note in one.notes],
        "behaviour": {name: _short(value) for name, value in one.behaviour.items()},
    }


def _stills(
    run: Run, morphologies: Mapping[tuple[float, ...], int]
) -> tuple[list[Any], dict[str, Any] | None]:
    """Return each morphology at rest, or `None`, and the view: the best and the champion's way."""
    # Drawing needs the simulator; reading a run without drawing it does not.
    from robomore.rendering.stills import still

    ranked = sorted(run.evaluations, key=lambda one: -(one.score(run.objective) or -1e300))
    first = [record.evaluation for record in run.lineage]
    wanted = dict.fromkeys(one.design.morphology.parameters for one in (*first, *ranked))
    stills: list[Any] = [None] * len(morphologies)
    view = None
    for parameters in list(wanted)[:MOST_STILLS]:
        try:
            stills[morphologies[parameters]], seen = still(run.task, parameters)
        except InvalidMorphology:  # it was tried, and refused; its diagnosis says why
            continue
        view = view or {name: getattr(seen, name).tolist() for name in ("right", "up", "towards")}
    return stills, view


_LARGEST, _NOTHING = 65_534, 65_535


def _curve(curve: Curve | None) -> dict[str, Any] | None:
    """Return a curve whose values are steps of a 65,534th from the least to the largest."""
    if curve is None:
        return None
    series = {}
    for name, values in curve.series.items():
        numbers = np.array([np.nan if value is None else value for value in values])
        # So that the range is a number, too, whatever somebody else's folder holds.
        numbers = np.clip(numbers, -1e300, 1e300)
        known = numbers[np.isfinite(numbers)]
        low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
        scaled = (numbers - low) * (_LARGEST / max(high - low, 1e-12))
        series[sanitize(name)] = {
            "low": low,
            "step": (high - low) / _LARGEST,
            "at": np.where(np.isfinite(scaled), np.round(scaled), _NOTHING).astype("<u2"),
        }
    return {"steps": np.array(curve.steps, np.float64).astype("<f4"), "series": series}


def _numbered(values: Any) -> dict[Any, int]:
    """Return each different value with its number, in the order in which they come."""
    return {value: number for number, value in enumerate(dict.fromkeys(values))}


def _short(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.6g}")
