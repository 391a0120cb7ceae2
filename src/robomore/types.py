"""The five nouns of RoboMoRe as frozen values: Morphology, Reward, Design, Job and Evaluation.

Everything that crosses a process boundary or lands in the ledger is one of these, encoded as JSON.
This module imports nothing of RoboMoRe but `text` and `transport`, and nothing heavy.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from robomore.text import encodable, one_line
from robomore.transport import cost_of_transport

_NAME = re.compile(r"\w[\w.-]{0,99}", re.ASCII)
"""Keys of evaluations, which are names of folders too."""
_MOST_STEPS = 2**53
_LARGEST = 1e12
"""Far from every length, angle and strength of a robot."""
_NOTHING = 1e-100
"""A smaller fitness is 0: its products and logarithms are no numbers."""


@dataclass(frozen=True, slots=True)
class Morphology:
    """Numbers in the order of the task's parameters, and one line that says the idea."""

    parameters: tuple[float, ...]
    idea: str = ""

    def __post_init__(self) -> None:
        if not all(abs(value) <= _LARGEST for value in self.parameters):  # not a number either
            raise ValueError(f"a parameter is not from -1e12 to {_LARGEST:g}; no robot has that")
        object.__setattr__(self, "idea", one_line(self.idea))


@dataclass(frozen=True, slots=True)
class Reward:
    """The program text of one reward: it defines `_get_rew(self, x_velocity, action)`."""

    source: str
    idea: str = ""

    def __post_init__(self) -> None:
        # Some editors and models put a byte order mark first.
        source = encodable(self.source).removeprefix("\ufeff")
        object.__setattr__(self, "source", source)
        object.__setattr__(self, "idea", one_line(self.idea))


@dataclass(frozen=True, slots=True)
class Design:
    """A morphology and the reward it is trained under: the unit that is evaluated."""

    morphology: Morphology
    reward: Reward


@dataclass(frozen=True, slots=True)
class Start:
    """What a search starts from, besides the reference design: a morphology, a reward, or both.

    Attributes:
        origin: where it comes from, such as a file or a run's folder.
        morphology: valid in the task of the run.
        reward: that passes the static check.
    """

    origin: str
    morphology: Morphology | None = None
    reward: Reward | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", encodable(self.origin))

    @property
    def content(self) -> tuple[tuple[float, ...] | None, str | None]:
        """Parameters and reward text: what numbers depend on, whatever its file is called."""
        parameters = self.morphology.parameters if self.morphology else None
        return parameters, self.reward.source if self.reward else None


class Status(StrEnum):
    """How an evaluation ended. Anything but `OK` comes with a diagnosis and without numbers."""

    OK = "ok"
    INVALID_MORPHOLOGY = "invalid-morphology"
    """Refused before training: out of bounds, against a rule, not compiled by MuJoCo, or unhealthy
    at every start."""
    INVALID_REWARD = "invalid-reward"
    """Refused before training: does not parse, or does not define the expected function."""
    REWARD_FAILED = "reward-failed"
    """Raised, or returned something that is not a finite number, while training."""
    UNSTABLE = "unstable"
    """The simulation diverged, in a short try before training or over and over in training."""
    TRAINING_DIVERGED = "training-diverged"
    """The trainer's own numbers did, which rewards of extreme size can cause."""
    TIMED_OUT = "timed-out"
    """Used up its wall-clock or CPU limit."""
    OUT_OF_MEMORY = "out-of-memory"
    CRASHED = "crashed"
    """The worker process died."""
    FAILED = "failed"
    """A fault of RoboMoRe itself; the diagnosis carries the traceback."""


@dataclass(frozen=True, slots=True)
class TrainerSettings:
    """Which algorithm trains a policy, and with what. Part of an evaluation's identity.

    `options` overrides single fields of the algorithm's own settings class by name
    (`robomore.training.settings`).
    """

    name: str = "crossq"
    options: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class MethodSettings:
    """Which search method decides what is tried, and with what.

    `options` overrides single fields of the method's own settings class by name
    (`robomore methods` lists them).
    """

    name: str = "robomore"
    options: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Limits:
    """What one evaluation may use before it is stopped. Not part of its identity."""

    wall_seconds: float = 3600.0
    reward_call_seconds: float = 1.0
    stall_seconds: float = 300.0
    """Longest time without any progress; compiling the trainer counts as none."""
    memory_bytes: int = 4 * 2**30
    file_bytes: int = 2**30

    @classmethod
    def for_steps(cls, steps: int) -> Limits:
        """Return limits for training of that length: an hour, or ten times what the slowest robot
        needs on a busy core."""
        return cls(wall_seconds=max(3600.0, 0.02 * steps))


@dataclass(frozen=True, slots=True)
class Job:
    """One evaluation to be done: a pure function of everything here but `limits`.

    Attributes:
        task: id of the task.
        design: what is trained.
        trainer: how it is trained.
        steps: control steps of training in all, over all environments together.
        episodes: episodes of the final measurement, each with its own seed.
        seed: seeds training; the measurement derives its own seeds from it.
        limits: when to give up.
        task_key: content key of the task itself (`robomore.tasks.fingerprint`), so that an edited
            task is another task. A worker refuses a job whose task it knows with another key.
    """

    task: str
    design: Design
    trainer: TrainerSettings
    steps: int
    episodes: int
    seed: int
    limits: Limits = Limits()
    task_key: str = ""


@dataclass(frozen=True, slots=True)
class TermStatistics:
    """One reward term over training: what a designer needs to see which term dominates."""

    mean: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Curve:
    """How a training went: at most 64 points, whatever its length (`robomore.training.curve`).

    Attributes:
        steps: control steps done at the end of each point, over all environments; rising.
        series: values by name, one for each point: the mean over what happened since the point
            before, and `None` where nothing did. Names are `episode_return`, `episode_length` (in
            control steps), `term/NAME` for each reward term, `loss/critic`, `loss/actor`, and
            `alpha` (weight of the policy's entropy).
    """

    steps: tuple[int, ...]
    series: dict[str, tuple[float | None, ...]]


@dataclass(frozen=True, slots=True)
class Evaluation:
    """What training one design gave.

    Attributes:
        key: content hash of the job and of the package versions that matter.
        job: what was asked.
        status: how it ended.
        diagnosis: empty when `OK`; else one paragraph for people and designers alike.
        fitness: mean over episodes; the task says what is measured, and in which unit.
        volume: material of the robot, in m³ (sum over geoms, overlaps counted twice).
        efficiency: fitness / volume.
        episode_fitness: fitness of each episode.
        body: plain facts of the robot: `mass` kg, `density` kg/m³, `rest_height` m.
        behaviour: how the policy moved, name -> value, units in the names.
        terms: statistics of each reward term over training.
        steps: control steps of training done; budgets count those asked for (`job.steps`).
        seconds: core-seconds spent (training and measurement).
        artifact: folder of the trained policy, relative to the run folder; empty if none.
        notes: facts worth keeping that are no failure ("the physics diverged in 1 episode").
        curve: how training went; `None` where nothing was trained, and where it is read apart
            (`Ledger.curve`).
    """

    key: str
    job: Job
    status: Status
    diagnosis: str = ""
    fitness: float | None = None
    volume: float | None = None
    efficiency: float | None = None
    episode_fitness: tuple[float, ...] = ()
    body: dict[str, float] = field(default_factory=dict)
    behaviour: dict[str, float] = field(default_factory=dict)
    terms: dict[str, TermStatistics] = field(default_factory=dict)
    steps: int = 0
    seconds: float = 0.0
    artifact: str = ""
    notes: tuple[str, ...] = ()
    curve: Curve | None = None

    def __post_init__(self) -> None:
        """Refuse what no evaluation has, so that it can always be kept and read again.

        Raises:
            ValueError: a number that is not finite, a name of a file that is no plain component of
                a path, or a name of a value that is not one line of text.
        """
        for name in ("fitness", "efficiency"):
            if (value := getattr(self, name)) is not None and abs(value) < _NOTHING:
                object.__setattr__(self, name, 0.0)
        numbers = (
            *(x for x in (self.fitness, self.volume, self.efficiency) if x is not None),
            *(*self.episode_fitness, *self.body.values(), *self.behaviour.values(), self.seconds),
            *(x for term in self.terms.values() for x in (term.mean, term.low, term.high)),
        )
        if not all(map(math.isfinite, numbers)):
            raise ValueError("one of its numbers is not finite")
        if not 0 <= self.steps < _MOST_STEPS or not 0 <= self.job.steps < _MOST_STEPS:
            raise ValueError("so many steps nobody trains")
        if not _NAME.fullmatch(self.key) or not _NAME.fullmatch(self.artifact or self.key):
            raise ValueError(f"key {self.key!r} or artifact {self.artifact!r} is no plain name")
        for name in (*self.body, *self.behaviour, *self.terms):
            if not name.isprintable():
                raise ValueError(f"the name {name[:50]!r} is not one line of text")

    @property
    def design(self) -> Design:
        return self.job.design

    @property
    def ok(self) -> bool:
        return self.status is Status.OK

    @property
    def energy(self) -> float | None:
        """Mechanical energy of the motors in an episode, in J; `None` where it was not measured."""
        return self.behaviour.get("energy_j")

    @property
    def cost_of_transport(self) -> float | None:
        """Energy / (mass * gravity * distance), without a unit: less is better.

        `None` where it was not measured, and for a robot that gets no farther than a fall would
        (`robomore.transport`), which transports nothing.
        """
        distance, mass = self.behaviour.get("forward_distance_m", 0.0), self.body.get("mass")
        if self.energy is None or mass is None:
            return None
        return cost_of_transport(distance, self.energy, mass, self.body.get("rest_height", 0.0))

    def score(self, objective: str = "efficiency") -> float | None:
        """The number the search compares, `None` for a failure; never a sentinel.

        Larger is better: `transport-economy` is 1 / cost of transport, and 0 where nothing is
        transported.
        """
        if not self.ok:
            return None
        if objective == "transport-economy":
            cost = self.cost_of_transport
            return 1 / cost if cost else 0.0 if self.energy is not None else None
        return self.efficiency if objective == "efficiency" else self.fitness


def finished(evaluations: Sequence[Evaluation]) -> list[Evaluation]:
    """Return those that were trained the longest, and those that failed on the way.

    Screening cuts the training of others short, and numbers after fewer steps do not compare.
    Where all that were to be trained to the end failed, the next ones stand in their place.
    """
    full = max((e.job.steps for e in evaluations if e.ok), default=0)
    return [e for e in evaluations if e.job.steps == full or not e.ok]


@dataclass(frozen=True, slots=True)
class Slot:
    """The place of one proposal in a run. Seeds its random state and names its LLM exchange,
    so that two identical prompts in two places stay two exchanges.

    Attributes:
        stage: name of a stage in the method's plan.
        kind: what is proposed, `morphology` or `reward`.
        index: position among the proposals of its stage and kind, counted from 0.
        improves: whether it improves on something that was measured.
        attempt: 0, or how many failed proposals came before it in the same place.
    """

    stage: str
    kind: str
    index: tuple[int, ...]
    improves: bool = False
    attempt: int = 0

    def __str__(self) -> str:
        """In words, counted from one: `coarse morphology 3`, `fine reward 1.2`."""
        return f"{self.stage} {self.kind} {'.'.join(str(i + 1) for i in self.index)}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Where in a run an evaluation was asked for; several places may share one evaluation.

    Attributes:
        stage: name of a stage in the run's plan (`robomore.plan`).
        index: position in that stage, counted from 0 along the stage's axes.
        changed: what is new against the parent: `morphology` or `reward`; in the final the role.
        parent: key of the evaluation whose design this one was made from; empty for a first idea.
        repeat: which training seed of this design.
    """

    stage: str
    index: tuple[int, ...] = ()
    changed: str = ""
    parent: str = ""
    repeat: int = 0


@dataclass(frozen=True, slots=True)
class Trial:
    """A design that the search wants measured, and why it wants to know."""

    design: Design
    place: Place
