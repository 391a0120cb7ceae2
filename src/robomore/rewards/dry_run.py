"""A reward tried out before it is trained under: a second now instead of a wasted training.

The reward runs in a contained child, as it does in training; here only what the child says is
read, and no more of it is believed than its type.
"""

from __future__ import annotations

import logging
import math
import re
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import msgspec
import numpy as np

from robomore.envs.vector_env import VectorEnv
from robomore.errors import UnstableSimulation
from robomore.identity import derive_seed
from robomore.rewards.check import NAME, Finding
from robomore.rewards.dry_run_findings import Rehearsed, Term, bodies, findings
from robomore.rewards.load import RewardFunction, load_reward
from robomore.sandbox.call import Containment, run_sandboxed
from robomore.tasks import Task, get_task
from robomore.types import Limits, Status

RANDOM_BODIES = 2
SIMULATIONS, STEPS = 4, 25
"""Of each body; together a hundred calls of the reward."""
_LIMITS = Limits(wall_seconds=120.0, reward_call_seconds=1.0, stall_seconds=60.0)
_BLAMELESS = (Status.FAILED, Status.UNSTABLE, Status.INVALID_MORPHOLOGY)
"""Ends of a rehearsal that say nothing about the reward."""
_MOST_TERMS = 64
_LONGEST = 1_000
"""Characters of a finding."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Play:
    """What the child is to do: a reward, and the bodies of a task that move under it."""

    task: str
    bodies: tuple[tuple[float, ...], ...]
    source: str


@dataclass(frozen=True, slots=True)
class DryRun:
    """Tries rewards out; called with a reward's text, it returns findings.

    Attributes:
        task: whose robot moves.
        scratch: folder for what the child writes; each call takes a folder of its own in it.
        containment: `strict` refuses to run rewards without the operating system's layers.
    """

    task: Task
    scratch: Path
    containment: Containment = Containment.STRICT

    def __call__(self, source: str) -> list[Finding]:
        """Return what is wrong with a reward, or probably wrong.

        Raises:
            InputError: the machine lacks a layer and containment is strict.
        """
        play = Play(self.task.id, tuple(bodies(self.task, RANDOM_BODIES)), source)
        self.scratch.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix="rehearsal-", dir=self.scratch) as scratch:
            ended = run_sandboxed(
                "robomore.rewards.dry_run:rehearse",
                msgspec.json.encode(play),
                Path(scratch),
                _LIMITS,
                mode=self.containment,
            )
        if ended.status in _BLAMELESS:
            _log.warning("no rehearsal: %s", ended.diagnosis)
            return []
        if ended.status is not Status.OK:
            return [_fault(ended.diagnosis, source)]
        try:
            seen = msgspec.json.decode(ended.reply, type=Rehearsed)
        except msgspec.DecodeError:
            return [_fault("the reward does something else than computing a number", source)]
        return findings(seen, _line(source))


def rehearse(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Let bodies move at random under a reward; what the contained child calls.

    Args:
        payload: an encoded `Play`.
        scratch: not used.
        report: told the bodies done.

    Returns:
        An encoded `Rehearsed`.

    Raises:
        InvalidReward, RewardFailed: the reasons are the reward's.
    """
    play = msgspec.json.decode(payload, type=Play)
    task = get_task(play.task)
    notes = _Notes(load_reward(play.source))
    for number, body in enumerate(play.bodies):
        random = np.random.default_rng(derive_seed("rehearsal", play.task, number))
        simulations = VectorEnv(task, body, SIMULATIONS, notes)
        try:
            simulations.reset(int(random.integers(2**31)))
            for _ in range(STEPS):
                shape = (SIMULATIONS, simulations.action_size)
                notes.rewards += simulations.step(random.uniform(-1, 1, shape)).reward.tolist()
        except UnstableSimulation:
            pass  # Not the reward's fault, and other bodies move.
        report(number + 1)
    return msgspec.json.encode(notes.seen())


@dataclass
class _Notes:
    """A reward with a clock beside it, and what it returned.

    It is an object and no function, so that it is called once per simulation, whatever could be
    done for many at once.
    """

    original: RewardFunction
    seconds: list[float] = field(default_factory=list)
    rewards: list[float] = field(default_factory=list)
    terms: dict[str, list[float]] = field(default_factory=dict)
    strange: dict[str, int] = field(default_factory=dict)

    def __call__(
        self, robot: Any, x_velocity: float, action: Any
    ) -> tuple[float, Mapping[str, float]]:
        """Return what the reward returns."""
        began = time.thread_time()
        result = self.original(robot, x_velocity, action)
        self.seconds.append(time.thread_time() - began)
        if type(result) is tuple and len(result) == 2 and isinstance(result[1], Mapping):
            self.note(result[1])
        return result

    def note(self, terms: Mapping[str, Any]) -> None:
        for name, value in terms.items():
            name = str(name)[:80]
            if name not in self.terms and len(self.terms) >= _MOST_TERMS:
                continue
            values = self.terms.setdefault(name, [])
            try:
                number = float(value)
            except (TypeError, ValueError, OverflowError):
                number = math.nan
            if math.isfinite(number):
                values.append(number)
            else:
                self.strange[name] = self.strange.get(name, 0) + 1

    def seen(self) -> Rehearsed:
        return Rehearsed(
            calls=len(self.rewards),
            low=min(self.rewards, default=0.0),
            high=max(self.rewards, default=0.0),
            seconds=statistics.median(self.seconds) if self.seconds else 0.0,
            terms={
                name: Term(
                    float(np.std(values)) if values and min(values) < max(values) else 0.0,
                    self.strange.get(name, 0),
                )
                for name, values in self.terms.items()
            },
        )


def _fault(diagnosis: str, source: str) -> Finding:
    said = " ".join(diagnosis.split())[:_LONGEST]
    line = re.search(r"\bline (\d+)\b", said)
    return Finding(int(line[1]) if line else _line(source), "error", f"when tried out: {said}")


def _line(source: str) -> int:
    """Return the line in which the function begins, for what concerns all of it."""
    before = source.partition(f"def {NAME}")[0]
    return before.count("\n") + 1
