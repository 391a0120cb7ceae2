"""What a study is: arms that are compared, and how their runs are told."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Any

from robomore.options import with_options
from robomore.runs import Run
from robomore.search import SearchContext, make_method
from robomore.search.final import stage as final_stage
from robomore.settings import RunSettings
from robomore.studies.table import Table
from robomore.tasks import get_task
from robomore.text import listed
from robomore.types import Design, Morphology, Reward

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Draw = Callable[["Axes | None"], "Axes"]
"""Draws one figure on the given axes, or on new ones."""


PROPOSED = {
    "method_options": {"screening": "none", "reference_reward": "out", "slim_reference": "out"}
}
"""Change of a preset for studies of first proposals: a grid of nothing else, all of it trained."""


@dataclass(frozen=True, slots=True)
class Arm:
    """One side of a comparison.

    Attributes:
        name: in tables and folders.
        options: of `robomore.options.with_options`, over the settings of the study.
        start_from: names of `robomore.search.named_starts`, from which its searches start.
    """

    name: str
    options: Mapping[str, Any] = field(default_factory=dict)
    start_from: tuple[str, ...] = ()

    def settings(self, plain: RunSettings) -> RunSettings:
        """Return the settings of this arm's runs."""
        return with_options(plain, **self.options)


@dataclass(frozen=True, slots=True)
class Cell:
    """One run of a study.

    Attributes:
        task: id of the task.
        arm: what is compared.
        seed: of the run.
        settings: of the run.
        budget_steps: control steps that its search may use, the same for every arm.
        retrains: the cell whose answer is trained here, and nothing searched; `None` for a search.
    """

    task: str
    arm: Arm
    seed: int
    settings: RunSettings
    budget_steps: int
    retrains: Cell | None = None

    @property
    def folder(self) -> Path:
        """Where its run lies in the study's folder."""
        return Path("cells") / f"{self.task}-{self.arm.name}-s{self.seed}"

    @property
    def most_steps(self) -> tuple[int, int]:
        """The most control steps of its search, and those of its final."""
        task, candidate = get_task(self.task), self.settings.candidate
        reference = Design(Morphology(task.reference, ""), Reward(task.reward, ""))
        context = SearchContext(
            task=task,
            reference=reference,
            candidate=candidate,
            evaluations=self.settings.evaluations,
            objective=self.settings.objective,
            seed=self.seed,
        )
        search = candidate.steps
        if self.retrains is None:
            stages = make_method(self.settings.method).plan(context).stages
            search = min(self.budget_steps, sum(stage.steps for stage in stages))
        return search, final_stage(self.settings.final).steps


@dataclass(frozen=True, slots=True)
class SeedScores:
    """What finals with one run seed measured of a design.

    Attributes:
        seed: of the run.
        values: what it was worth; one number, or one for each training.
        trainings: keys of the evaluations behind them. Two arms that answer alike with one seed
            have the very same ones.
    """

    seed: int
    values: tuple[float, ...]
    trainings: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Results:
    """The runs of a study.

    Attributes:
        cells: each cell with its run, which may have found nothing.
        again: scores of designs that were once the best so far of a search, by the evaluation's
            key, measured again (`robomore.studies.remeasured`).
        others: names of the runs in the study's folder that are not among the cells.
    """

    cells: tuple[tuple[Cell, Run], ...]
    again: Mapping[str, float] = field(default_factory=dict)
    others: tuple[str, ...] = ()

    @property
    def tasks(self) -> tuple[str, ...]:
        """The tasks in their order."""
        return tuple(dict.fromkeys(cell.task for cell, _ in self.cells))

    @property
    def arms(self) -> tuple[str, ...]:
        """Names of the arms in their order."""
        return tuple(dict.fromkeys(cell.arm.name for cell, _ in self.cells))

    @property
    def fitness_unit(self) -> str:
        """Unit of the tasks' fitness; empty where they have none, or not the same one."""
        units = {run.fitness_unit for run in self.runs()}
        return units.pop() if len(units) == 1 else ""

    @property
    def objective(self) -> str:
        """What all runs compared."""
        return self.cells[0][1].objective

    def runs(self, task: str | None = None, arm: str | None = None) -> list[Run]:
        """Return the runs of a task and of an arm, or of all of them."""
        return [
            run
            for cell, run in self.cells
            if task in (None, cell.task) and arm in (None, cell.arm.name)
        ]

    def scores(self, task: str, arm: str) -> list[float]:
        """Return what each run's answer was worth in the final; runs without one are left out.

        It is the search's own answer, trained anew, and not the champion: the champion may be one
        of the final's other pairs, which every method gets for nothing.
        """
        return [value for one in self.answers(task, arm) for value in one.values]

    def answers(self, task: str, arm: str) -> list[SeedScores]:
        """Return the score of each run's answer with its seed; runs without one are left out."""
        found = []
        for cell, run in self.cells:
            if (cell.task, cell.arm.name) == (task, arm) and run.found:
                keys = frozenset(one.key for one in run.found.evaluations)
                if measured := run.found.score(self.objective):
                    found.append(SeedScores(cell.seed, (measured.mean,), keys))
        return found

    def reference(self, task: str) -> float | None:
        """Return what the reference design is worth in the finals of all runs of a task."""
        values = [value for one in self.references(task) for value in one.values]
        return fmean(values) if values else None

    def references(self, task: str) -> list[SeedScores]:
        """Return what the reference design is worth in each of its trainings, in all finals.

        Runs with the same seed have the same trainings of it, which count once.
        """
        known: set[str] = set()
        found: dict[int, dict[str, float]] = {}
        for cell, run in self.cells:
            for one in run.reference.evaluations if cell.task == task and run.reference else ():
                score = one.score(self.objective)
                if score is not None and one.key not in known:
                    found.setdefault(cell.seed, {})[one.key] = score
                    known.add(one.key)
        return [
            SeedScores(seed, tuple(scores.values()), frozenset(scores))
            for seed, scores in found.items()
        ]


@dataclass(frozen=True, slots=True)
class Study:
    """A grid of runs.

    Attributes:
        name: on the command line.
        summary: one line for `robomore study`.
        arms: what is compared.
        tables: made of the results.
        figures: likewise, by name.
        tasks: that are used if none are named.
        change: of the preset's settings, before an arm's own.
        searched: the task whose search gives the design that is trained in all other tasks; empty
            for a search in each of them.
        whole_grid: whether each search may use as many full trainings as the grid has pairs.
        curves: whether its figures hold curves of the best so far (`scores.curve_figures`), for
            which the policies behind them are measured again.
    """

    name: str
    summary: str
    arms: tuple[Arm, ...]
    tables: Callable[[Results], list[Table]]
    figures: Callable[[Results], dict[str, Draw]] = lambda results: {}
    tasks: tuple[str, ...] = ("swimmer",)
    change: Mapping[str, Any] = field(default_factory=dict)
    searched: str = ""
    whole_grid: bool = False
    curves: bool = False

    def told(self, results: Results) -> list[Table]:
        """Return the tables of the results; where the folder holds more runs, each says so."""
        left_out = _left_out(results)
        return [
            replace(table, note=f"{table.note} {left_out}".strip())
            for table in self.tables(results)
        ]


def _left_out(results: Results) -> str:
    """Return which runs the tables cover, where the study's folder holds others; else `""`."""
    if not results.others:
        return ""
    count = len(results.others)
    return (
        f"This table covers only what its call named: {', '.join(results.arms)} on "
        f"{', '.join(results.tasks)}. Left out {'is' if count == 1 else 'are'} {count} other "
        f"run{'' if count == 1 else 's'} in the same folder ({listed(results.others)}); a call "
        "that names those too tells of all, and repeats none."
    )
