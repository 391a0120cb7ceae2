"""Several runs side by side: what each found, over its own reference, and what it cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robomore.runs.loading import load_run
from robomore.runs.run import Run
from robomore.runs.table import Row, dataframe
from robomore.statistics.spread import Spread


@dataclass(frozen=True, slots=True)
class Comparison:
    """Runs in the order they were given."""

    runs: tuple[Run, ...]

    def rows(self) -> list[Row]:
        """Return one row a run; the same columns for every method.

        Units: fitness as the task says (`Run.fitness_unit`), volume m³, energy J, efficiency that
        of fitness over m³. `found` is what the search answered, trained anew. Methods are compared
        by it and by `found_ratio`, that over the reference, where they have the same objective and
        steps of each training (`training_steps`, `final_training_steps`). `ratio` is champion over
        reference: the champion is the best of all pairs of the final, so that more pairs have more
        luck. A ratio has its 95 % interval where there are seeds enough for one.
        """
        return [_row(run) for run in self.runs]

    def to_dataframe(self) -> Any:
        """Return the rows as a `pandas.DataFrame`; `InputError` without pandas."""
        return dataframe(self.rows())


def compare(runs: Sequence[Run | str | Path]) -> Comparison:
    """Return runs side by side.

    Args:
        runs: runs, or their folders.

    Raises:
        RunFolderError: one is no run folder.
    """
    return Comparison(tuple(run if isinstance(run, Run) else load_run(run) for run in runs))


def _row(run: Run) -> Row:
    manifest, champion, reference = run.manifest, run.champion, run.reference
    return {
        "run": str(run.folder),
        "task": manifest.task,
        "method": manifest.settings.method.name,
        "preset": manifest.preset,
        "designer": manifest.designer,
        "seed": manifest.seed,
        "finished": run.final,
        "objective": run.objective,
        "training_steps": manifest.settings.candidate.steps,
        "final_training_steps": manifest.settings.final.steps,
        "final_seeds_asked": manifest.settings.final.seeds,
        "champion": _mean(champion.score(run.objective) if champion else None),
        "found": _mean(run.found.score(run.objective) if run.found else None),
        "reference": _mean(reference.score(run.objective) if reference else None),
        **_ratio("ratio", run.ratio),
        **_ratio("found_ratio", run.found_ratio),
        "final_seeds": len(champion.trained) if champion and run.final else 0,
        "fitness": _mean(champion.fitness if champion else None),
        "volume": champion.volume if champion else None,
        "energy": champion.behaviour.get("energy_j") if champion else None,
        "pareto_set": len(run.pareto_set),
        "hypervolume": run.hypervolume,
        "proposed_by": run.champion_role,
        "evaluations": run.cost.evaluations,
        "search_steps": run.search_steps,
        "steps": run.cost.steps,
        "core_seconds": run.cost.core_seconds,
    }


def _ratio(name: str, measured: Spread | None) -> Row:
    low, high = (measured.interval if measured else None) or (None, None)
    return {name: _mean(measured), f"{name}_low": low, f"{name}_high": high}


def _mean(measured: Spread | None) -> float | None:
    return measured.mean if measured else None
