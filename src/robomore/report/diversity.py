"""How different the designs of a run are: two maps, and the paper's two numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robomore.report.heatmap import colours, share
from robomore.report.svg import axis_around, element, figure, text, tip
from robomore.runs import Run
from robomore.runs.bounds import share_of_range
from robomore.runs.lineage import Record
from robomore.runs.words import in_unit, label
from robomore.statistics.diversity import coefficient_of_variation, self_bleu, tokens

_WIDTH, _HEIGHT, _EDGE = 400.0, 290.0, 22.0
_MOST_CHARACTERS = 10_000
"""Of a reward that are compared with the others; usual ones have a fifth of that."""

_MOST_REWARDS = 30
"""Rewards whose texts are compared with each other, spread evenly over the search."""


@dataclass(frozen=True, slots=True)
class Diversity:
    """How different the designs of a search are.

    Attributes:
        maps: (title, figure, what its axes are) of morphologies and of behaviour.
        facts: (name, value) in words.
    """

    maps: tuple[tuple[str, str, str], ...]
    facts: tuple[tuple[str, str], ...]


def diversity(run: Run) -> Diversity | None:
    """Return how different a run's designs are; `None` where there are too few to tell."""
    shown = [record for record in run.searched if record.evaluation.ok]
    morphologies = list(dict.fromkeys(r.evaluation.design.morphology.parameters for r in shown))
    if len(shown) < 4:
        return None
    maps = []
    if len(morphologies) > 3:
        numbers = [
            [
                share_of_range(parameter, value)
                for parameter, value in zip(
                    run.task.parameters, r.evaluation.design.morphology.parameters, strict=True
                )
            ]
            for r in shown
        ]
        drawn, said = _map(run, shown, np.array(numbers), run.task.names, "morphologies")
        maps.append(("Map of the morphologies", drawn, said))
    names = sorted(set.intersection(*(set(r.evaluation.behaviour) for r in shown)))
    behaviour = np.array([[r.evaluation.behaviour[name] for name in names] for r in shown])
    varied = [i for i in range(len(names)) if np.ptp(behaviour[:, i]) > 1e-9]
    if len(varied) > 1:
        ranked = behaviour[:, varied].argsort(axis=0).argsort(axis=0) / len(shown)
        labels = [label(names[i]) for i in varied]
        drawn, said = _map(run, shown, ranked, labels, "behaviour")
        maps.append(("Map of how they move", drawn, said))
    rewards = list(dict.fromkeys(r.evaluation.design.reward.source for r in shown))
    facts = [
        ("different morphologies", str(len(morphologies))),
        ("different rewards", str(len(rewards))),
    ]
    if len(morphologies) > 1:
        variation = coefficient_of_variation(morphologies)
        facts.append(("variation of the parameters (deviation / mean)", f"{variation:.3f}"))
    if len(rewards) > 1:
        some = rewards[:: -(-len(rewards) // _MOST_REWARDS)]
        bleu = self_bleu([tokens(source[:_MOST_CHARACTERS]) for source in some])
        facts.append(("Self-BLEU of the rewards (less is more diverse)", f"{bleu:.3f}"))
    return Diversity(tuple(maps), tuple(facts))


def _map(
    run: Run,
    shown: Sequence[Record],
    numbers: NDArray[np.float64],
    names: Sequence[str],
    what: str,
) -> tuple[str, str]:
    """Return the two directions in which designs differ most, as a map, and what they stand for."""
    centred = numbers - numbers.mean(axis=0)
    _, sizes, directions = np.linalg.svd(centred, full_matrices=False)
    flat = centred @ directions[:2].T
    explained = 100 * (sizes[:2] ** 2).sum() / max(float((sizes**2).sum()), 1e-12)
    x = axis_around(flat[:, 0].tolist(), _EDGE, _WIDTH - 8)
    y = axis_around(flat[:, 1].tolist(), _HEIGHT - _EDGE, 8)
    scores = [record.evaluation.score(run.objective) or 0.0 for record in shown]
    positive = [score for score in scores if score > 0] or [1.0]
    ends = min(positive), max(positive)
    parts = [
        element("path", d=f"M{x.start} {y.end}V{y.start}H{x.end}", klass="axis"),
        text("first direction", (x.start + x.end) / 2, _HEIGHT - 6, text_anchor="middle"),
    ]
    champion = run.champion.design if run.champion else None
    order = sorted(range(len(shown)), key=scores.__getitem__)
    for i in order:
        evaluation = shown[i].evaluation
        worth = in_unit(scores[i], run.objective, run.fitness_unit)
        said = f"{run.plan.describe(shown[i].place)}: {worth}"
        at = x.at(float(flat[i, 0])), y.at(float(flat[i, 1]))
        fill, _ = colours(share(scores[i], *ends))
        mark = element("circle", cx=at[0], cy=at[1], r=5, fill=fill, klass="spot")
        if evaluation.design == champion:
            mark += element("circle", cx=at[0], cy=at[1], r=8, klass="ring champion")
        parts.append(tip(said, mark, evaluation.key))
    strongest = [
        ", ".join(names[j] for j in np.argsort(-np.abs(directions[axis]))[:2])
        for axis in range(min(2, len(directions)))
    ]
    said = (
        f"Principal components; they hold {explained:.0f} % of the differences. Across: mostly "
        f"{strongest[0]}; upwards: mostly {strongest[-1]}. Bright is better."
    )
    return figure(_WIDTH, _HEIGHT, f"Map of {what}", parts), said
