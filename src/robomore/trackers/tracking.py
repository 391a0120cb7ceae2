"""From the events of a run to numbers by name, for all of its trackers."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any

import msgspec

from robomore.errors import InputError
from robomore.events import Event, Finished, RunBegan, Spent
from robomore.identity import same_training
from robomore.text import to_json
from robomore.trackers.registry import TRACKERS
from robomore.trackers.tracker import Tracked, Tracker
from robomore.types import Evaluation

log = logging.getLogger(__name__)


class RunTracking:
    """An observer of a run. A tracker that fails is left out with one warning; the run goes on.

    Each evaluation counts once, in the order in which it finished. Numbers of the search and of the
    final have names of their own: `search/fitness`, `final/fitness`.
    """

    def __init__(self, names: Sequence[str]) -> None:
        """Find the trackers; nothing is started before the run begins.

        Raises:
            InputError: a name is unknown, or its package is not installed.
        """
        self._kinds = {name: TRACKERS.get(name) for name in names}
        for name, kind in self._kinds.items():
            if kind.package and find_spec(kind.package) is None:
                raise InputError(
                    f"the tracker {name!r} needs {kind.package}, which is not installed; install "
                    f"it with {kind.install}"
                )
        self._trackers: dict[str, Tracker] = {}
        self._began: RunBegan | None = None
        self._seen: set[str] = set()
        self._longest: dict[object, int] = {}
        self._best: float | None = None
        self._totals = {"cost/steps": 0.0, "cost/core_seconds": 0.0, "cost/failed": 0.0}

    def __call__(self, event: Event) -> None:
        """Take up an event."""
        match event:
            case RunBegan():
                self._begin(event)
            case Finished(evaluation=evaluation) if evaluation.key not in self._seen:
                self._seen.add(evaluation.key)
                self._log(self._values(event))
            case Spent(requests=requests, tokens=tokens, dollars=dollars):
                money = {} if dollars is None else {"llm/dollars": dollars}
                self._log({"llm/requests": requests, "llm/tokens": tokens, **money})

    def close(self) -> None:
        """Finish all trackers."""
        for name in list(self._trackers):
            self._guarded(name, lambda tracker: tracker.close())
        self._trackers.clear()

    def _begin(self, event: RunBegan) -> None:
        self._began = event
        settings: dict[str, Any] = {
            "task": event.task,
            "preset": event.preset,
            "designer": event.designer,
            "seed": event.seed,
            **msgspec.json.decode(to_json(event.settings)),
        }
        tracked = Tracked(event.folder, event.folder.resolve().name, settings)
        for name, kind in self._kinds.items():
            try:
                self._trackers[name] = kind(tracked)
            except Exception as error:  # noqa: BLE001  # somebody else's package and server
                self._leave_out(name, error)

    def _values(self, event: Finished) -> dict[str, float]:
        evaluation, began = event.evaluation, self._began
        self._totals["cost/steps"] += self._new_steps(evaluation)
        self._totals["cost/core_seconds"] += evaluation.seconds
        self._totals["cost/failed"] += not evaluation.ok
        values = dict(self._totals)
        if began is None or not evaluation.ok:
            return values
        role = began.plan.stage(event.place.stage).role
        objective = began.settings.objective
        values |= _numbers(evaluation, role)
        score = evaluation.score(objective)
        # Designs whose training was cut short do not compare.
        whole = evaluation.job.steps >= began.settings.candidate.steps
        if role == "search" and whole and score is not None:
            self._best = score if self._best is None else max(self._best, score)
        if self._best is not None:
            values[f"search/best_{objective}"] = self._best
        return values

    def _new_steps(self, evaluation: Evaluation) -> int:
        """Return the control steps beyond what its training had; a failed one counts in full."""
        training = same_training(evaluation)
        before = self._longest.get(training, 0)
        self._longest[training] = max(before, evaluation.job.steps)
        return self._longest[training] - before

    def _log(self, values: dict[str, float]) -> None:
        for name in list(self._trackers):
            self._guarded(name, lambda tracker: tracker.log(values, len(self._seen)))

    def _guarded(self, name: str, act: Any) -> None:
        try:
            act(self._trackers[name])
        except Exception as error:  # noqa: BLE001  # somebody else's package and server
            self._leave_out(name, error)

    def _leave_out(self, name: str, error: Exception) -> None:
        self._trackers.pop(name, None)
        log.warning(
            "the tracker %s is left out from now on (%s: %s); the run goes on",
            name,
            type(error).__name__,
            error,
        )


def _numbers(evaluation: Evaluation, role: str) -> dict[str, float]:
    numbers = {
        "fitness": evaluation.fitness,
        "volume": evaluation.volume,
        "efficiency": evaluation.efficiency,
        "energy": evaluation.energy,
    }
    return {f"{role}/{name}": value for name, value in numbers.items() if value is not None}
