"""A run folder as one frozen value: what `show`, the page and the end of a run all tell."""

from __future__ import annotations

from collections import Counter
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robomore.errors import InputError
from robomore.llm import Spending
from robomore.plan import Plan
from robomore.runs.cost import Cost, spent_seconds, trained_steps
from robomore.runs.empty import EmptySlot
from robomore.runs.failures import Failure, failures_of
from robomore.runs.lineage import Record, ancestry, best_of
from robomore.runs.pairs import Pairs, crossed_pairs
from robomore.runs.pareto import covered, pareto_set
from robomore.runs.table import Row, dataframe, rows
from robomore.runs.trained import TrainedDesign, over, trained_design
from robomore.runs.warnings import warnings_about
from robomore.settings import Objective
from robomore.statistics.spread import Spread
from robomore.store import Ledger, Manifest, RunFolder
from robomore.store.schema import Proposal
from robomore.tasks import Task
from robomore.types import Curve, Evaluation, Place, Status

if TYPE_CHECKING:
    import gymnasium

    from robomore.training.policy import MLPPolicy

FEWEST_FOR_HEADLINE = 3
"""Training seeds that trained, on either side, below which no ratio is put into a headline."""


@dataclass(frozen=True, kw_only=True)
class Run:
    """A run, finished or not, read once from its folder.

    Attributes:
        folder: of the run.
        manifest: what was asked for.
        task: that it was asked for, as it is installed here.
        final: whether the champion is the run's last word; else it is the best so far.
        champion: the best pair of the final; the best so far before it; `None` while nothing has
            been trained.
        champion_role: which group of the final the champion is: `found`, `morphology_only`,
            `reward_only` or `reference`; empty before the final.
        found: the search's best, in the final.
        reference: the reference design in the final.
        morphology_only: the found morphology under the reference reward, in the final.
        reward_only: the reference morphology under the found reward, in the final.
        records: every evaluation in each place it was asked for, in the order of the search; of a
            training that went on from rung to rung, the last.
        measured: every evaluation, those after earlier rungs of screening too, oldest first.
        untried: places that screening left out altogether, and why.
        proposals: what the designer answered, oldest first.
        empty: slots that the designer could not fill.
        spending: on a language model; nothing where none was asked.
        task_changes: parts of the task that were edited since the run.
        passed_over: designs that failed their audit and could not be champion, and why.
        containment: how rewards were kept in, in words, where that was not strictly; else empty.
        budget_steps: control steps that the search might use; `None` for no bound.
        focus: key of the evaluation that stands in the champion's place (`focused`); else empty.
    """

    folder: Path
    manifest: Manifest
    task: Task
    final: bool
    champion: TrainedDesign | None
    champion_role: str
    found: TrainedDesign | None
    reference: TrainedDesign | None
    morphology_only: TrainedDesign | None
    reward_only: TrainedDesign | None
    records: tuple[Record, ...]
    measured: tuple[Evaluation, ...]
    untried: dict[Place, str]
    proposals: tuple[Proposal, ...]
    empty: tuple[EmptySlot, ...]
    spending: Spending
    task_changes: tuple[str, ...]
    passed_over: tuple[str, ...] = ()
    containment: str = ""
    budget_steps: int | None = None
    focus: str = ""

    def __repr__(self) -> str:
        """Return one line: its numbers and texts have a place in reports."""
        state = "finished" if self.final else "not finished"
        count = len(self.evaluations)
        return f"<Run of {self.task.id} in {str(self.folder)!r}: {state}, {count} evaluations>"

    # Numbers -------------------------------------------------------------------------------------

    @property
    def plan(self) -> Plan:
        """The stages that the method meant to go through, the final among them."""
        return self.manifest.plan

    @property
    def is_smoke(self) -> bool:
        """Whether its preset only checks that everything runs."""
        return self.manifest.preset.split("-")[0] == "smoke"

    @property
    def objective(self) -> Objective:
        """What the search compared: `efficiency`, `fitness` or `transport-economy`."""
        return self.manifest.settings.objective

    @property
    def fitness_unit(self) -> str:
        """Unit of the task's fitness; empty for a number without one."""
        return self.task.goal.unit

    @cached_property
    def efficiency_ratio(self) -> Spread | None:
        """Champion's efficiency over the reference's."""
        return over(self.champion, self.reference, "efficiency")

    @cached_property
    def fitness_ratio(self) -> Spread | None:
        """Champion's fitness over the reference's."""
        return over(self.champion, self.reference, "fitness")

    @cached_property
    def ratio(self) -> Spread | None:
        """Champion over reference in what the search compared."""
        return over(self.champion, self.reference, self.objective)

    @cached_property
    def found_ratio(self) -> Spread | None:
        """What the search answered over the reference, whether or not it became the champion."""
        return over(self.found, self.reference, self.objective)

    @property
    def headline(self) -> Spread | None:
        """The ratio, if something was found, was trained, and has seeds enough for a headline."""
        if not self.final or self.champion_role == "reference" or self.is_smoke:
            return None
        sides = [one for one in (self.champion, self.reference) if one is not None]
        if min(len(one.trained) for one in sides) < FEWEST_FOR_HEADLINE:
            return None
        base = self.reference.score(self.objective) if self.reference else None
        # What is divided by a reference that may be worth nothing can be any number.
        return self.ratio if base and min(base.values) > 0 else None

    @cached_property
    def pairs(self) -> Pairs | None:
        """The pairs of the final side by side; `None` before it, or if there is one pair only."""
        return crossed_pairs(self)

    @cached_property
    def evaluations(self) -> tuple[Evaluation, ...]:
        """Every evaluation once, without its curve, in the order of the search."""
        return tuple({r.evaluation.key: r.evaluation for r in self.records}.values())

    @cached_property
    def searched(self) -> tuple[Record, ...]:
        """Records of the search that were trained to the end, or failed."""
        full = self.manifest.settings.candidate.steps
        return tuple(
            record
            for record in self.records
            if self.plan.stage(record.place.stage).role == "search"
            and (record.evaluation.job.steps >= full or not record.evaluation.ok)
        )

    @cached_property
    def cut(self) -> tuple[Record, ...]:
        """Records of the search that screening cut short."""
        whole = {id(record) for record in self.searched}
        return tuple(
            record
            for record in self.records
            if self.plan.stage(record.place.stage).role == "search" and id(record) not in whole
        )

    @cached_property
    def lineage(self) -> tuple[Record, ...]:
        """How the search found its best: a first idea, and each improvement."""
        if self.focus:
            key = self.focus
        elif self.found is not None:
            parents = [
                r.place.parent
                for r in self.records
                if r.evaluation.key == self.found.evaluations[0].key and r.place.parent
            ]
            key = parents[0] if parents else ""
        else:
            best = best_of((r.evaluation for r in self.searched), self.objective)
            key = best.key if best else ""
        return ancestry(key, self.searched)

    @property
    def counts(self) -> dict[Status, int]:
        """Evaluations by status, the most frequent first."""
        return dict(Counter(evaluation.status for evaluation in self.evaluations).most_common())

    @cached_property
    def cost(self) -> Cost:
        """What everything took."""
        return Cost(
            evaluations=len(self.evaluations),
            steps=trained_steps(self.measured),
            core_seconds=sum(evaluation.seconds for evaluation in self.measured),
        )

    @cached_property
    def core_seconds(self) -> dict[str, float]:
        """Core-seconds by the key of an evaluation, with those of the rungs before it."""
        return spent_seconds(self.measured)

    @cached_property
    def search_steps(self) -> int:
        """Control steps of training that the search took, the final left out."""
        final = {stage.name for stage in self.plan.stages if stage.role == "final"}
        search = (r.evaluation for r in self.records if r.place.stage not in final)
        return trained_steps({e.key: e for e in search}.values())

    @cached_property
    def failures(self) -> tuple[Failure, ...]:
        """What failed, by reason, the most frequent first."""
        return failures_of(self.records)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What to keep in mind before believing the champion, the most important first."""
        return warnings_about(self)

    @cached_property
    def pareto_set(self) -> tuple[Evaluation, ...]:
        """Evaluations of the search that no other beats in fitness, volume and energy at once."""
        return pareto_set(self)

    @cached_property
    def hypervolume(self) -> float | None:
        """What the Pareto set covers, relative to the reference (`robomore.runs.pareto`)."""
        return covered(self)

    # Tables --------------------------------------------------------------------------------------

    def rows(self) -> list[Row]:
        """Return one row an evaluation and place, in the order of the search."""
        return rows(self.records, self.core_seconds, self.task, self.plan)

    def to_dataframe(self) -> Any:
        """Return the rows as a `pandas.DataFrame`; `InputError` without pandas."""
        return dataframe(self.rows())

    # One evaluation ------------------------------------------------------------------------------

    def evaluation(self, key: str) -> Evaluation:
        """Return the evaluation of a key, or of the beginning of one that fits no other.

        Raises:
            InputError: none has it, or several begin with it.
        """
        found = [e for e in self.evaluations if e.key.startswith(key)] if key else []
        if len(found) == 1 or (found and found[0].key == key):
            return found[0]
        said = f"{len(found)} evaluations begin with" if found else "no evaluation has the key"
        raise InputError(
            f"{said} {key!r} in {self.folder}; `robomore export {self.folder} --csv FILE` lists "
            "them all"
        )

    def focused(self, key: str) -> Run:
        """Return this run with one evaluation in the champion's place, to be shown like it.

        Raises:
            InputError: there is no such evaluation.
        """
        evaluation = self.evaluation(key)
        place = next(r.place for r in self.records if r.evaluation.key == evaluation.key)
        shown = trained_design(self.plan.describe(place), self.task, [evaluation])
        return replace(self, champion=shown, champion_role="", final=False, focus=evaluation.key)

    def curve(self, key: str) -> Curve | None:
        """Return how the training of an evaluation went; `None` if it was not trained.

        Raises:
            InputError: there is no such evaluation.
        """
        return self.curves().get(self.evaluation(key).key)

    def curves(self) -> dict[str, Curve]:
        """Return how each training went, by the key of its evaluation."""
        with closing(Ledger(RunFolder(self.folder).ledger, read_only=True)) as ledger:
            return ledger.curves()

    def load_policy(self, key: str | None = None) -> MLPPolicy:
        """Return the trained policy of an evaluation, by default of the champion's best seed.

        Raises:
            InputError: there is no such evaluation, or it has no policy.
        """
        from robomore.training.policy import POLICY, MLPPolicy

        evaluation = self.kept(key)
        path = RunFolder(self.folder).artifacts / evaluation.artifact / POLICY
        if not evaluation.artifact or not path.is_file():
            why = evaluation.diagnosis or "its file is missing; run the same command again"
            raise InputError(f"the evaluation {evaluation.key} has no policy: {why}")
        try:
            return MLPPolicy.load(path)
        except ValueError as error:
            raise InputError(f"{path} cannot be used ({error}); run the command again") from None

    def make_env(self, key: str | None = None, **options: Any) -> gymnasium.Env[Any, Any]:
        """Return a Gymnasium environment of an evaluation's morphology and task.

        Its reward is the reference reward: an evaluation's own may come from anybody and is only
        run in the sandbox.

        Args:
            key: of the evaluation; the champion's by default.
            options: for `gymnasium.make`, such as `render_mode`.

        Raises:
            InputError: there is no such evaluation.
        """
        from gymnasium.wrappers import TimeLimit

        from robomore.envs.registration import make_environment

        evaluation = self.kept(key)
        parameters = evaluation.design.morphology.parameters
        environment = make_environment(self.task, parameters, **options)
        return TimeLimit(environment, self.task.episode_steps)

    def report(self, out: str | Path | None = None) -> Path:
        """Write the run's page; returns its path (`report.html` in the folder by default)."""
        # The one import upwards: whoever holds a run looks for its report here.
        from robomore.report import write_report

        return write_report(self.folder, Path(out) if out else None)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the numbers, and champion and reference moving."""
        from robomore.report import notebook_html

        return notebook_html(self)

    def kept(self, key: str | None = None) -> Evaluation:
        """Return the evaluation of a key, by default of the champion's best training seed.

        Raises:
            InputError: there is none.
        """
        if key is not None:
            return self.evaluation(key)
        if self.champion is None or not self.champion.trained:
            raise InputError(f"{self.folder} has nothing trained yet; wait, or run it on")
        return self.champion.best(self.objective)
