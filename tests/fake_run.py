"""A finished run, written through the ledger's own interface: nothing is trained."""

from __future__ import annotations

import random
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from robomore.settings import Budget, RunSettings, SearchSettings
from robomore.store import Ledger, Manifest, RunFolder
from robomore.store.champion import save_champion
from robomore.tasks import get_task
from robomore.types import (
    Design,
    Evaluation,
    Job,
    Morphology,
    Place,
    Reward,
    Status,
    TermStatistics,
    TrainerSettings,
)

SETTINGS = RunSettings(
    search=SearchSettings(
        morphologies=4, rewards=3, survivors=0.17, max_cycles=2, finalists=1, repeats=3
    ),
    trainer=TrainerSettings("crossq"),
    candidate=Budget(steps=1_000, episodes=2),
    final=Budget(steps=4_000, episodes=4),
)
PROVENANCE = "No LLM was used: a stand-in proposed these designs for a test."
NASTY = "<script>alert('x')</script> & more"
"""What a designer could write; it must never become part of a page."""


class FakeRun:
    """Writes one evaluation after the other, as a run would."""

    def __init__(self, path: Path, task: str = "swimmer", settings: RunSettings = SETTINGS) -> None:
        self.task = get_task(task)
        self.path = path
        manifest = Manifest(task, self.task.version, "quick", "offline", PROVENANCE, 7, settings)
        self.settings = settings
        self.folder = RunFolder.prepare(path, manifest)
        self.folder.release()
        self._draw = random.Random(1)
        self.count = 0

    def morphology(self, shrink: float, idea: str = "thin") -> Morphology:
        """Return the human body with its radii multiplied by `shrink`."""
        return Morphology(
            tuple(
                max(p.low, p.reference * shrink) if "radius" in p.name else p.reference
                for p in self.task.parameters
            ),
            idea,
        )

    def reward(self, weight: float) -> Reward:
        """Return a reward that rates speed by `weight`."""
        return Reward(
            f'def _get_rew(self, x_velocity, action):\n    """{NASTY}"""\n'
            f"    forward = {weight!r} * x_velocity  # metres a second\n"
            '    return forward, {"forward": forward}\n',
            f"speed times {weight:g}",
        )

    def add(
        self,
        design: Design,
        place: Place,
        fitness: float | None,
        status: Status = Status.OK,
        diagnosis: str = "",
    ) -> Evaluation:
        """Write down one evaluation in one place."""
        final = place.stage == "final"
        budget = self.settings.final if final else self.settings.candidate
        self.count += 1
        job = Job(
            self.task.id, design, self.settings.trainer, budget.steps, budget.episodes, self.count
        )
        volume = self.task.volume(design.morphology.parameters)
        evaluation = Evaluation(
            f"key{self.count:03d}",
            job,
            status,
            diagnosis,
            body={"mass": 1000 * volume, "density": 1000.0, "rest_height": 0.0},
            seconds=2.5,
        )
        if fitness is not None:
            evaluation = replace(
                evaluation,
                fitness=fitness,
                volume=volume,
                efficiency=fitness / volume,
                episode_fitness=(fitness - 0.5, fitness + 0.5),
                terms={"forward": TermStatistics(1.0, -1.0, 3.0)},
                steps=budget.steps,
            )
        with closing(Ledger(self.folder.ledger)) as ledger:
            ledger.add_place(place, evaluation.key)
            ledger.add_evaluation(evaluation)
        return evaluation

    def coarse(self) -> None:
        """Fill the grid; morphology 3 x reward 2 fails, morphology 4 x reward 3 is best."""
        for i in range(4):
            for j in range(3):
                design = Design(self.morphology(1 - 0.2 * i, f"shrunk {i}"), self.reward(1.0 + j))
                place = Place(stage="coarse", morphology=i, reward=j)
                if (i, j) == (2, 1):
                    self.add(design, place, None, Status.REWARD_FAILED, f"line 3: {NASTY}")
                else:
                    self.add(design, place, 10.0 + i + j)

    def fine(self) -> Design:
        """Refine two branches; the first finds the champion, whose design is returned."""
        best = Design(self.morphology(0.3, "thinner still"), self.reward(3.0))
        self.add(best, _fine(0, "morphology"), 14.0)
        other = Design(self.morphology(0.5), self.reward(2.0))
        self.add(other, _fine(1, "morphology"), 3.0)
        worse = Design(best.morphology, self.reward(9.0))
        self.add(worse, _fine(0, "reward"), -1.0)
        self.add(worse, _fine(1, "reward"), None, Status.TIMED_OUT, "slow")
        return best

    def final(self, best: Design, fitness: tuple[float, ...] = (12.0, 13.0, 14.0)) -> None:
        """Retrain champion and human design, and end the run."""
        human = Design(
            Morphology(self.task.reference, "the official robot"), Reward(self.task.reward)
        )
        champion = [
            self.add(best, Place(stage="final", changed="champion", repeat=r), value)
            for r, value in enumerate(fitness, 1)
        ]
        for r, value in enumerate((20.0, 21.0, 22.0)[: len(fitness)], 1):
            self.add(human, Place(stage="final", changed="human", repeat=r), value)
        save_champion(self.folder, self.task, champion, "efficiency")
        with closing(Ledger(self.folder.ledger)) as ledger:
            ledger.add_event("finished", champion=[evaluation.key for evaluation in champion])


def _fine(branch: int, changed: str) -> Place:
    return Place(stage="fine", cycle=1, branch=branch, changed=changed)


def finished_run(path: Path, task: str = "swimmer") -> FakeRun:
    """Write a whole run into `path`."""
    run = FakeRun(path, task)
    run.coarse()
    run.final(run.fine())
    return run
