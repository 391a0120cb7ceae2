"""A dry run of a reward before it is trained under: a second now instead of a wasted training.

The reward runs in a sandboxed process, as it does in training. Only that process's answer is read
here, and it is checked against a schema.
"""

from __future__ import annotations

import logging
import math
import re
import statistics
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from robomore.envs.robots.base import RewardFunction
from robomore.envs.vector_env import VectorEnv
from robomore.errors import UnstableSimulation
from robomore.identity import derive_seed
from robomore.plain_files import scratch_folder
from robomore.rewards.check import NAME, Finding
from robomore.rewards.continuation import check_continuation
from robomore.rewards.dry_run_findings import Apart, Growth, Observed, Term, findings, morphologies
from robomore.rewards.growth import amounts, growth, marks
from robomore.rewards.load import load_reward
from robomore.rewards.silent import line_now, silent_findings
from robomore.sandbox.call import Containment, run_sandboxed
from robomore.tasks import Task
from robomore.tasks.portable import task_content
from robomore.tasks.registry import carried_task
from robomore.text import one_line
from robomore.types import Limits, Status

RANDOM_MORPHOLOGIES = 2
NUM_ENVS, STEPS = 4, 50
"""For each morphology; together two hundred calls of the reward."""
_HELD = (1, 1, 5, 15)
"""Control steps for which each simulation keeps its random action: longer ones move it further."""
_LIMITS = Limits(wall_seconds=120.0, reward_call_seconds=1.0, stall_seconds=60.0)
_BLAMELESS = (Status.FAILED, Status.UNSTABLE, Status.INVALID_MORPHOLOGY)
"""Ends of a dry run that say nothing about the reward."""
_MOST_SECONDS = 10.0
"""Processor time after which a reward is not tried further: it is refused as too slow."""
_MOST_TERMS = 64
_ROUNDING = 1e-4
"""Part of the sizes of terms by which they may miss the reward: numbers of 32 bits are rounded."""
_LONGEST = 1_000
"""Characters of a finding."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class DryRunRequest:
    """What the sandboxed process is to do: move these morphologies of a task under a reward."""

    task: str
    morphologies: tuple[tuple[float, ...], ...]
    source: str
    content: bytes = b""


@dataclass(frozen=True, slots=True)
class DryRunResult:
    """What a dry run has shown.

    Attributes:
        findings: what is wrong, or probably wrong, or good to know.
        observed: statistics; `None` if the reward failed, or nothing could be tried.
    """

    findings: list[Finding]
    observed: Observed | None = None


@dataclass(frozen=True, slots=True)
class DryRun:
    """Tries rewards; called with a reward's text, it returns findings.

    Attributes:
        task: whose robot moves.
        scratch: folder for what the sandboxed process writes; each call takes a folder of its own
            in it.
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
        return self.result(source).findings

    def result(self, source: str) -> DryRunResult:
        """Return what is wrong with a reward, and its statistics.

        Raises:
            InputError: the machine lacks a layer and containment is strict.
        """
        drawn = tuple(morphologies(self.task, RANDOM_MORPHOLOGIES))
        self.scratch.mkdir(parents=True, exist_ok=True)
        with scratch_folder(self.scratch, "dry-run-") as scratch:
            ended = run_sandboxed(
                "robomore.rewards.dry_run:observe",
                msgspec.json.encode(
                    DryRunRequest(self.task.id, drawn, source, task_content(self.task))
                ),
                scratch,
                _LIMITS,
                mode=self.containment,
            )
        if ended.status in _BLAMELESS:
            _log.warning("no dry run: %s", ended.diagnosis)
            said = f"could not be tried out: {one_line(ended.diagnosis)[:_LONGEST]}"
            return DryRunResult([Finding(_line(source), "note", said)])
        if ended.status is not Status.OK:
            return DryRunResult([_fault(ended.diagnosis, source)])
        try:
            observed = msgspec.json.decode(ended.reply, type=Observed)
        except msgspec.DecodeError:
            said = "the reward does something else than computing a number"
            return DryRunResult([_fault(said, source)])
        clean = {one_line(name)[:_LONGEST]: term for name, term in observed.terms.items()}
        observed = replace(observed, terms=clean)
        found = [*findings(observed, source), *silent_findings(observed, source)]
        return DryRunResult(found, observed)


def observe(payload: bytes, scratch: Path, report: Callable[[int], None]) -> bytes:
    """Let robots move at random under a reward; runs in the sandboxed process.

    Args:
        payload: an encoded `DryRunRequest`.
        scratch: not used.
        report: called with the number of morphologies that are done.

    Returns:
        An encoded `Observed`.

    Raises:
        InvalidReward, RewardFailed: the reasons are the reward's.
    """
    request = msgspec.json.decode(payload, type=DryRunRequest)
    task = carried_task(request.task, request.content)
    record = _Record()
    reward = load_reward(request.source, record.watch)
    for number, parameters in enumerate(request.morphologies):
        random = np.random.default_rng(derive_seed("dry run", request.task, number))
        env = VectorEnv(task, parameters, NUM_ENVS, reward)
        try:
            env.reset(int(random.integers(2**31)))
            actions = np.zeros((NUM_ENVS, env.action_size))
            before = marks(env)
            for step in range(STEPS):
                if not number and step == STEPS // 2:
                    halfway = amounts(env)
                anew = [index for index, held in enumerate(_HELD) if step % held == 0]
                actions[anew] = random.uniform(-1, 1, (len(anew), env.action_size))
                record.rewards += env.step(actions).reward.tolist()
                if sum(record.seconds) > _MOST_SECONDS:
                    # Nothing else is tried either: the check below would take as long again.
                    return msgspec.json.encode(record.observed())
            record.lasting |= {name for name, one in marks(env).items() if before.get(name) != one}
            if not number:
                record.over = True
                record.growth = growth(env, halfway, task.episode_steps)
                record.over = False
        except UnstableSimulation:
            pass  # Not the reward's fault, and other morphologies move.
        if env.reward_runner is not None:
            record.missing |= env.reward_runner.missing.found
        report(number + 1)
    check_continuation(task, request.morphologies[0], load_reward(request.source))
    return msgspec.json.encode(record.observed())


@dataclass
class _Record:
    """How long each call of a reward took and what it returned."""

    seconds: list[float] = field(default_factory=list)
    rewards: list[float] = field(default_factory=list)
    terms: dict[str, list[float]] = field(default_factory=dict)
    not_finite: dict[str, int] = field(default_factory=dict)
    hidden: dict[str, int] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)
    growth: dict[str, Growth] = field(default_factory=dict)
    lasting: set[str] = field(default_factory=set)
    apart: Apart | None = None
    over: bool = False

    def watch(self, function: RewardFunction) -> RewardFunction:
        """Return `function` with each call recorded."""

        def recorded(robot: Any, x_velocity: float, action: Any) -> Any:
            if self.over:
                with np.errstate(all="ignore"):
                    return function(robot, x_velocity, action)
            faults: set[str] = set()

            def note(kind: str, flag: int) -> None:
                faults.add(f"{line_now(sys._getframe(1))} {kind}")

            with np.errstate(divide="call", invalid="call", call=note):
                began = time.thread_time()
                result = function(robot, x_velocity, action)
                self.seconds.append(time.thread_time() - began)
            for fault in faults:
                if fault in self.hidden or len(self.hidden) < _MOST_TERMS:
                    self.hidden[fault] = self.hidden.get(fault, 0) + 1
            if type(result) is tuple and len(result) == 2 and isinstance(result[1], Mapping):
                self._record(*result)
            return result

        return recorded

    def _record(self, reward: Any, terms: Mapping[str, Any]) -> None:
        given: list[float] = []
        for name, value in terms.items():
            name = str(name)[:80]
            if name not in self.terms and len(self.terms) >= _MOST_TERMS:
                continue
            values = self.terms.setdefault(name, [])
            try:
                number = float(value)
            except (TypeError, ValueError, OverflowError):
                number = math.nan
            given.append(number)
            if math.isfinite(number):
                values.append(number)
            else:
                self.not_finite[name] = self.not_finite.get(name, 0) + 1
        if given and len(given) == len(terms):
            self._add_up(reward, given)

    def _add_up(self, reward: Any, terms: list[float]) -> None:
        """Note whether all terms of a call add up to its reward, but for rounding."""
        try:
            returned, total = float(reward), math.fsum(terms)
            size = math.fsum(map(abs, (returned, *terms)))
        except (TypeError, ValueError, OverflowError):
            return  # Whatever is wrong with such numbers, something else says it.
        if math.isfinite(size) and abs(total - returned) > _ROUNDING * size:
            before = self.apart or Apart(0, total, returned)
            self.apart = replace(before, calls=before.calls + 1)

    def observed(self) -> Observed:
        whole = _term(self.rewards, 0)
        return Observed(
            calls=len(self.rewards),
            low=whole.low,
            high=whole.high,
            seconds=statistics.median(self.seconds) if self.seconds else 0.0,
            terms={
                name: _term(values, self.not_finite.get(name, 0))
                for name, values in self.terms.items()
            },
            mean=whole.mean,
            spread=whole.spread,
            usual=statistics.median_low(map(abs, self.rewards)) if self.rewards else 0.0,
            hidden=self.hidden,
            missing=self.missing,
            growth=self.growth,
            lasting=tuple(sorted(self.lasting)[:_MOST_TERMS]),
            apart=self.apart,
        )


def _term(values: list[float], not_finite: int) -> Term:
    """Return the statistics of finite values, however large they are."""
    low, high = min(values, default=0.0), max(values, default=0.0)
    scale = max(abs(low), abs(high))
    if low == high or scale == 0:
        return Term(0.0, not_finite, low, low, high)
    scaled = np.array(values) / scale
    spread, mean = scale * float(np.std(scaled)), scale * float(np.mean(scaled))
    return Term(spread, not_finite, mean, low, high)


def _fault(diagnosis: str, source: str) -> Finding:
    said = one_line(diagnosis)[:_LONGEST]
    line = re.search(r"\bline (\d+)\b", said)
    return Finding(int(line[1]) if line else _line(source), "error", f"when tried out: {said}")


def _line(source: str) -> int:
    """Return the line in which the function begins, for what concerns all of it."""
    before = source.partition(f"def {NAME}")[0]
    return before.count("\n") + 1
