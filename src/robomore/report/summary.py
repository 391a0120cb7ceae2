"""A run folder as one frozen value: what `show`, the page and the end of a run all tell."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from robomore.errors import RunFolderError
from robomore.llm import Spending
from robomore.report.empty import EmptySlot, empty_slots, pairs_without
from robomore.report.finalists import Contestant, contestant, finalists, measured_in_final
from robomore.report.lineage import Step, best_of, in_order, way
from robomore.report.metrics import Spread, ratio
from robomore.report.warnings import cautions
from robomore.store import Ledger, LedgerExchanges, Manifest, RunFolder
from robomore.tasks import Task, get_task
from robomore.types import Evaluation, Place, Status


@dataclass(frozen=True, slots=True)
class Failure:
    """Evaluations that failed for one reason.

    Attributes:
        status: how they ended.
        diagnosis: of the first of them.
        places: where in the run.
    """

    status: Status
    diagnosis: str
    places: tuple[Place, ...]


@dataclass(frozen=True, slots=True)
class Cost:
    """What a run has spent: every evaluation counts once, wherever it was asked for."""

    evaluations: int
    steps: int
    core_seconds: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """A run, finished or not.

    Attributes:
        folder: of the run.
        manifest: what was asked for.
        task: that it was asked for.
        final: whether the champion is the run's last word; else it is the best so far.
        champion: `None` while nothing has been trained.
        human: the human design as measured in the final; `None` before that.
        efficiency_ratio: champion's efficiency over the human design's.
        fitness_ratio: champion's fitness over the human design's.
        counts: evaluations by status.
        cost: of all evaluations.
        spending: on a language model; nothing where none was asked.
        way: from the best of the grid to the champion.
        placed: every evaluation in each place it was asked for, in the order of the search; but
            not those that screening cut short.
        cut: those, with the fewer steps that they had.
        untried: pairs of the grid that were left out altogether, and why.
        empty: slots that the designer could not fill.
        failures: by reason, the most frequent first.
        cautions: what to keep in mind before believing the champion.
    """

    folder: Path
    manifest: Manifest
    task: Task
    final: bool
    champion: Contestant | None
    human: Contestant | None
    efficiency_ratio: Spread | None
    fitness_ratio: Spread | None
    counts: dict[Status, int]
    cost: Cost
    spending: Spending
    way: tuple[Step, ...]
    placed: tuple[tuple[Place, Evaluation], ...]
    cut: tuple[tuple[Place, Evaluation], ...]
    untried: dict[Place, str]
    empty: tuple[EmptySlot, ...]
    failures: tuple[Failure, ...]
    cautions: tuple[str, ...]

    @property
    def objective(self) -> str:
        """What the search compared: `efficiency` or `fitness`."""
        return self.manifest.settings.search.objective

    @property
    def ratio(self) -> Spread | None:
        """Champion over human in what the search compared."""
        return self.efficiency_ratio if self.objective == "efficiency" else self.fitness_ratio


def summarise(path: Path) -> Summary:
    """Read a run folder.

    Raises:
        RunFolderError: it is no run folder.
        LedgerError: its ledger is damaged.
        InputError: its task is not installed here.
    """
    folder = RunFolder.existing(path)
    manifest = Manifest.load(folder.manifest)
    task = get_task(manifest.task)
    if not folder.ledger.is_file():
        raise RunFolderError(f"{path} has no ledger; start its run again with the same command")
    with closing(Ledger(folder.ledger, read_only=True)) as ledger:
        everything = ledger.evaluations()
        asked = in_order(ledger.placed())
        untried = {cut.place: cut.reason for cut in ledger.cuts() if not cut.steps}
        empty = empty_slots(ledger.proposals())
        crowned = [event for event in ledger.events() if event.kind == "finished"]
    with closing(LedgerExchanges(folder.ledger, read_only=True)) as exchanges:
        spending = exchanges.spent()
    untried |= pairs_without(empty, manifest.settings.search)
    full = manifest.settings.candidate.steps
    cut = [(p, e) for p, e in asked if p.stage == "coarse" and e.ok and e.job.steps < full]
    placed = [pair for pair in asked if pair not in cut and pair[0].stage != "screening"]
    objective = manifest.settings.search.objective
    keys = set(crowned[-1].body.get("champion", ())) if crowned else set()

    groups = finalists(placed)
    winner = next((g for g in groups if keys and keys == {e.key for e in g}), None)
    best = best_of((e for place, e in placed if place.stage != "final"), objective)
    champion = None
    if winner:
        champion = contestant("champion", task, winner)
    elif best:
        champion = contestant("best so far", task, [best])
    trained_human = measured_in_final(placed, "human")
    human = contestant("human", task, trained_human) if trained_human else None

    return Summary(
        folder=path,
        manifest=manifest,
        task=task,
        final=winner is not None,
        champion=champion,
        human=human,
        efficiency_ratio=_ratio(champion, human, "efficiency"),
        fitness_ratio=_ratio(champion, human, "fitness"),
        counts=_counts(everything),
        cost=_cost(everything),
        spending=spending,
        way=way(placed, manifest.settings.search, winner or ()),
        placed=tuple(placed),
        cut=tuple(cut),
        untried=untried,
        empty=empty,
        failures=_failures(asked),
        cautions=cautions(
            manifest, task, champion, human, final=winner is not None, found=best, empty=empty
        ),
    )


def _ratio(champion: Contestant | None, human: Contestant | None, name: str) -> Spread | None:
    above = getattr(champion, name, None)
    below = getattr(human, name, None)
    return ratio(above.values, below.values) if above and below else None


def _distinct(placed: Iterable[tuple[Place, Evaluation]]) -> list[Evaluation]:
    return list({evaluation.key: evaluation for _, evaluation in placed}.values())


def _counts(evaluations: Sequence[Evaluation]) -> dict[Status, int]:
    return dict(Counter(evaluation.status for evaluation in evaluations).most_common())


def _cost(evaluations: Sequence[Evaluation]) -> Cost:
    # A training that went on from rung to rung has an evaluation for each, of the same steps.
    longest: dict[tuple[object, ...], int] = {}
    for evaluation in evaluations:
        design = evaluation.design
        training = (design.morphology.parameters, design.reward.source, evaluation.job.seed)
        longest[training] = max(evaluation.steps, longest.get(training, 0))
    return Cost(
        evaluations=len(evaluations),
        steps=sum(longest.values()),
        core_seconds=sum(evaluation.seconds for evaluation in evaluations),
    )


def _failures(placed: Sequence[tuple[Place, Evaluation]]) -> tuple[Failure, ...]:
    groups: dict[tuple[Status, str], list[Place]] = {}
    for place, evaluation in placed:
        if not evaluation.ok:
            groups.setdefault((evaluation.status, evaluation.diagnosis), []).append(place)
    found = [
        Failure(status, diagnosis, tuple(places)) for (status, diagnosis), places in groups.items()
    ]
    return tuple(sorted(found, key=lambda failure: -len(failure.places)))
