"""Whether found rewards are better than the reference reward, from the finals of a study's runs.

Each final trains the found morphology under the reference reward too, with as many seeds. Nobody
has to run anything for this table.
"""

from __future__ import annotations

import math
from statistics import fmean

from robomore.runs import Run
from robomore.statistics.spread import FEWEST, mean_interval
from robomore.studies.study import Results
from robomore.studies.table import Entry, Table


def group_score(run: Run, group: str, objective: str) -> float | None:
    """Return the mean score of a group of a run's final (`found`, `morphology_only`, …)."""
    design = getattr(run, group)
    measured = design.score(objective) if design else None
    return measured.mean if measured else None


def reward_table(results: Results) -> Table:
    """Return the found reward over the reference reward on the same found morphology, by task."""
    rows: list[tuple[Entry, ...]] = []
    for task in results.tasks:
        runs = results.runs(task)
        same = sum(bool(run.found) and not _other_reward(run) for run in runs)
        # Arms that answer alike with the same seed have one pair, not two.
        ratios = list(
            dict(pair for run in runs if (pair := _pair(run, results.objective))).values()
        )
        logs = [math.log(one) for one in ratios]
        interval: tuple[float | None, float | None] = (None, None)
        if len(logs) >= FEWEST:
            low, high = mean_interval(logs)
            interval = math.exp(low), math.exp(high)
        mean = math.exp(fmean(logs)) if logs else None
        better = f"{sum(one > 1 for one in ratios)} of {len(ratios)}"
        rows.append((task, mean, *interval, better, same))
    return Table(
        "reward",
        "The found reward over the reference reward, both with the found morphology",
        ("task", "geometric mean", "95 % from", "95 % to", "found is better", "found none"),
        tuple(rows),
        "Runs of all arms that found a reward, each pair trained anew with as many seeds; without "
        f"those with a score that is not above 0. The interval is Student's, of {FEWEST} pairs or "
        "more. The last column counts runs that answered with the reference reward.",
    )


def _other_reward(run: Run) -> bool:
    found, reference = run.found, run.reference
    return bool(
        found and reference and found.design.reward.source != reference.design.reward.source
    )


def _pair(run: Run, objective: str) -> tuple[str, float] | None:
    """Return the key of what was found, and its score over that under the reference reward."""
    if not run.found or not _other_reward(run):
        return None
    found = group_score(run, "found", objective)
    plain = group_score(run, "morphology_only", objective)
    if not found or not plain or min(found, plain) <= 0:
        return None
    return run.found.evaluations[0].key, found / plain
