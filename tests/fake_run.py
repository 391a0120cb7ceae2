"""Runs written through the ledger's own interface: nothing is trained."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

from robomore.plan import Plan, Stage
from robomore.search import SearchContext, make_method
from robomore.search.final import FOUND, MORPHOLOGY_ONLY, REFERENCE, REWARD_ONLY
from robomore.search.final import STAGE as FINAL
from robomore.search.final import stage as final_stage
from robomore.settings import Budget, FinalSettings, RunSettings
from robomore.store import Ledger, Manifest, RunFolder
from robomore.store.champion import save_champion
from robomore.tasks import get_task
from robomore.tasks.fingerprint import fingerprint, task_key
from robomore.transport import GRAVITY
from robomore.types import (
    Curve,
    Design,
    Evaluation,
    Job,
    MethodSettings,
    Morphology,
    Place,
    Reward,
    Status,
    TermStatistics,
    TrainerSettings,
)

SETTINGS = RunSettings(
    method=MethodSettings(
        "robomore", {"morphologies": 4, "rewards": 3, "survivors": 0.17, "max_cycles": 2}
    ),
    trainer=TrainerSettings("crossq"),
    candidate=Budget(steps=1_000, episodes=2),
    final=FinalSettings(steps=4_000, episodes=4, seeds=5),
    evaluations=20,
)
PROVENANCE = "No LLM was used: a stand-in proposed these designs for a test."
NASTY = "<script>alert('x')</script> & more"
"""What a designer could write; it must never become part of a page."""

FOUND_FITNESS = (12.0, 12.5, 13.0, 13.5, 14.0)
REFERENCE_FITNESS = (20.0, 20.5, 21.0, 21.5, 22.0)
MORPHOLOGY_ONLY_FITNESS = (6.0, 6.5, 7.0, 7.5, 8.0)
REWARD_ONLY_FITNESS = (20.5, 21.0, 21.5, 22.0, 22.5)
"""In m, one for each training seed of a final."""
Fitness = tuple[float | None, ...]
"""Likewise; `None` for a training that failed."""


class FakeRun:
    """Writes one evaluation after the other, as a run would.

    Args:
        path: the run's folder.
        task: id of the task.
        settings: of the run; by default a small search of the method `robomore`.
        plan: stages of the search; needed for a method that is not installed.
        preset: name of the settings.
        energy: of each episode, in J; `None` where it is not measured.
    """

    def __init__(
        self,
        path: Path,
        task: str = "swimmer",
        settings: RunSettings = SETTINGS,
        plan: Plan | None = None,
        preset: str = "quick",
        energy: float | None = None,
    ) -> None:
        self.task = get_task(task)
        self.path = path
        self.settings = settings
        self.reference = Design(
            Morphology(self.task.reference, "the reference design"),
            Reward(self.task.reward, "the reference reward"),
        )
        designer = "offline"
        if plan is None:
            method = make_method(settings.method)
            designer = "offline" if method.needs_designer else ""
            plan = method.plan(
                SearchContext(
                    task=self.task,
                    reference=self.reference,
                    candidate=settings.candidate,
                    evaluations=settings.evaluations,
                )
            )
        self.manifest = Manifest(
            task=task,
            task_parts=fingerprint(self.task),
            preset=preset,
            designer=designer,
            provenance=PROVENANCE,
            seed=7,
            settings=settings,
            plan=Plan((*plan.stages, final_stage(settings.final))),
        )
        self.folder = RunFolder.prepare(path, self.manifest)
        self.folder.release()
        self.count = 0
        self.energy = energy

    def morphology(self, shrink: float, idea: str = "thin") -> Morphology:
        """Return the reference morphology with its radii multiplied by `shrink`."""
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
        steps: int | None = None,
    ) -> Evaluation:
        """Write down one evaluation in one place.

        Args:
            design: what was trained.
            place: where in the run.
            fitness: in m; `None` for a failure.
            status: how it ended.
            diagnosis: of a failure.
            steps: of training; by default those of the place's stage.
        """
        budget = self.settings.final if place.stage == FINAL else self.settings.candidate
        steps = budget.steps if steps is None else steps
        self.count += 1
        job = Job(
            task=self.task.id,
            design=design,
            trainer=self.settings.trainer,
            steps=steps,
            episodes=budget.episodes,
            seed=self.count,
            task_key=task_key(self.task),
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
            gained = {"height_gain_m": fitness - 4} if self.task.goal.name == "height" else {}
            evaluation = replace(
                evaluation,
                fitness=fitness,
                volume=volume,
                efficiency=fitness / volume,
                episode_fitness=(fitness - 0.5, fitness + 0.5),
                behaviour={
                    "forward_distance_m": fitness,
                    "forward_speed_m_s": fitness / 10,
                    **gained,
                    **({} if self.energy is None else {"energy_j": self.energy}),
                },
                terms={"forward": TermStatistics(1.0, -1.0, 3.0)},
                steps=steps,
                curve=curve(steps, fitness),
            )
        with closing(Ledger(self.folder.ledger)) as ledger:
            ledger.add_place(place, evaluation.key)
            ledger.add_evaluation(evaluation)
        return evaluation

    def fail(self, evaluation: Evaluation) -> None:
        """Write down that the training of an evaluation failed after all."""
        failed = replace(
            evaluation,
            status=Status.UNSTABLE,
            diagnosis="it fell apart",
            fitness=None,
            volume=None,
            efficiency=None,
            episode_fitness=(),
        )
        with closing(Ledger(self.folder.ledger)) as ledger:
            ledger.add_evaluation(failed)

    def coarse(self) -> Evaluation:
        """Fill the grid, whose first column is the reference reward; returns its best.

        Morphology 3 x reward 2 fails, morphology 4 x reward 3 is best.
        """
        for i in range(4):
            for j in range(3):
                reward = self.reward(1.0 + j) if j else self.reference.reward
                design = Design(self.morphology(1 - 0.2 * i, f"shrunk {i}"), reward)
                place = Place(stage="coarse", index=(i, j))
                if (i, j) == (2, 1):
                    self.add(design, place, None, Status.REWARD_FAILED, f"line 3: {NASTY}")
                else:
                    best = self.add(design, place, 10.0 + i + j)
        return best

    def fine(self, start: Evaluation | None = None) -> Evaluation:
        """Refine two branches from `start` on; returns the first one's best."""
        parent = start.key if start else ""

        def place(branch: int, changed: str, parent: str) -> Place:
            return Place(stage="fine", index=(branch, 0), changed=changed, parent=parent)

        design = Design(self.morphology(0.3, "thinner still"), self.reward(3.0))
        best = self.add(design, place(0, "morphology", parent), 14.0)
        other = Design(self.morphology(0.5), self.reward(2.0))
        self.add(other, place(1, "morphology", parent), 3.0)
        worse = Design(design.morphology, self.reward(9.0))
        self.add(worse, place(0, "reward", best.key), -1.0)
        self.add(worse, place(1, "reward", parent), None, Status.TIMED_OUT, "slow")
        return best

    def final(
        self,
        best: Evaluation,
        found: Fitness = FOUND_FITNESS,
        reference: Fitness = REFERENCE_FITNESS,
        morphology_only: Fitness = MORPHOLOGY_ONLY_FITNESS,
        reward_only: Fitness = REWARD_ONLY_FITNESS,
        champion: str = "found",
    ) -> None:
        """Train `best`, the reference design and the crossed pairs anew, and end the run.

        Args:
            best: of the search.
            found: fitness of the best design, in m, one for each training seed.
            reference: likewise of the reference design.
            morphology_only: likewise of the found morphology under the reference reward.
            reward_only: likewise of the reference morphology under the found reward.
            champion: the group that is named champion.
        """
        design, plain = best.design, self.reference
        crossed = Design(design.morphology, plain.reward), Design(plain.morphology, design.reward)
        groups: dict[str, list[Evaluation]] = {}
        known: dict[tuple[object, ...], Evaluation] = {}
        for name, role, one, values in (
            ("found", FOUND, design, found),
            ("reference", REFERENCE, plain, reference),
            ("morphology_only", MORPHOLOGY_ONLY, crossed[0], morphology_only),
            ("reward_only", REWARD_ONLY, crossed[1], reward_only),
        ):
            groups[name] = []
            for repeat, value in enumerate(values, 1):
                parent = "" if name == "reference" else best.key
                place = Place(stage=FINAL, index=(0,), changed=role, parent=parent, repeat=repeat)
                # The same design under the same seed is one evaluation in two places.
                same = (one.morphology.parameters, one.reward.source, repeat)
                if same in known:
                    with closing(Ledger(self.folder.ledger)) as ledger:
                        ledger.add_place(place, known[same].key)
                else:
                    ended = (Status.OK, "") if value is not None else (Status.TIMED_OUT, "slow")
                    known[same] = self.add(one, place, value, *ended)
                groups[name].append(known[same])
        groups["champion"] = groups[champion]
        save_champion(self.folder, self.task, groups["champion"], self.settings.objective)
        with closing(Ledger(self.folder.ledger)) as ledger:
            keys = {
                name: [evaluation.key for evaluation in group] for name, group in groups.items()
            }
            ledger.add_event("finished", **keys)


def curve(steps: int, fitness: float) -> Curve:
    """Return a training curve of five points that rises to `fitness`."""
    at = tuple(steps * i // 5 for i in range(1, 6))
    rising = tuple(fitness * i / 5 for i in range(1, 6))
    return Curve(
        at,
        {
            "episode_return": (None, *rising[1:]),
            "episode_length": (None, 100.0, 100.0, 100.0, 100.0),
            "term/forward": rising,
            "term/<b>effort": tuple(-value / 10 for value in rising),
            "loss/critic": (1.0, 0.8, 0.6, 0.4, 0.2),
        },
    )


def finished_run(path: Path, task: str = "swimmer") -> FakeRun:
    """Write a whole run of the method `robomore` into `path`."""
    run = FakeRun(path, task)
    run.final(run.fine(run.coarse()))
    return run


ENERGY = 50.0
"""In J, of each episode of `economy_run`."""


def economy(fitness: float, volume: float) -> float:
    """Return the transport economy of a robot of `economy_run`."""
    return 1000 * volume * GRAVITY * fitness / ENERGY


def economy_run(path: Path, task: str = "swimmer") -> FakeRun:
    """Write a whole run into `path` that compared transport economy."""
    settings = replace(SETTINGS, objective="transport-economy")
    run = FakeRun(path, task, settings, energy=ENERGY)
    run.final(run.fine(run.coarse()))
    return run


def random_run(path: Path) -> FakeRun:
    """Write a whole run of the method `random` into `path`: every sample has the same reward."""
    run = FakeRun(path, settings=replace(SETTINGS, method=MethodSettings("random")))
    for n in range(4):
        design = Design(run.morphology(1 - 0.2 * n), run.reference.reward)
        best = run.add(design, Place(stage="samples", index=(n,)), 10.0 + n)
    run.final(best)
    return run


def reference_run(path: Path) -> FakeRun:
    """Write a whole run of the method `reference` into `path`: nothing is searched."""
    run = FakeRun(path, settings=replace(SETTINGS, method=MethodSettings("reference")))
    only = run.add(run.reference, Place(stage="reference"), 20.0)
    run.final(only, found=REFERENCE_FITNESS)
    return run


def foreign_run(path: Path) -> FakeRun:
    """Write a whole run into `path` of a method that is not installed, with stages of its own."""
    plan = Plan(
        (
            Stage(name="matrix", axes=("morphology", "reward"), shape=(2, 2), evaluations=4),
            Stage(name="evolution", axes=("generation", "member"), shape=(2, 2), evaluations=4),
        )
    )
    settings = replace(SETTINGS, method=MethodSettings("ours", {"size": 3}))
    run = FakeRun(path, settings=settings, plan=plan, preset="custom")
    for i in range(2):
        for j in range(2):
            design = Design(run.morphology(1 - 0.2 * i), run.reward(1.0 + j))
            best = run.add(design, Place(stage="matrix", index=(i, j)), 10.0 + i + j)
    for generation in range(2):
        design = Design(run.morphology(0.5 - 0.1 * generation), run.reward(2.0))
        place = Place(stage="evolution", index=(generation, 0), parent=best.key)
        best = run.add(design, place, 14.0 + generation)
    run.final(best)
    return run
