"""Runs a reward after each control step: once per simulation, each with a `self` of its own."""

from __future__ import annotations

import inspect
import linecache
import math
import traceback
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs import reward_state
from robomore.envs.read_only import ReadOnly, read_only_data
from robomore.envs.robots.base import Array, RewardFunction, RobotEnvironment
from robomore.envs.term_record import TermRecord, as_number
from robomore.errors import RewardFailed
from robomore.types import TermStatistics

REWARD_FILENAME = "<reward>"
"""The name under which a reward's text is compiled, and its lines stand in tracebacks."""

_LONGEST = 500
"""Characters of a stranger's own words that a diagnosis repeats."""


class PerSimulationReward:
    """The slow path that is always right: one call per simulation and step.

    `self` is a copy of the robot's environment, so everything that the official class offers is
    there, on data of that simulation which can be read and not changed. What the reward keeps in
    `self` is its own, one per simulation, and gone when an episode ends.

    Attributes:
        terms: statistics of what the reward returned.
        inherited: attributes of the environment that every `self` has.
        data: of each simulation, read-only.
    """

    def __init__(
        self,
        reward: RewardFunction,
        environment: RobotEnvironment,
        data: Sequence[mujoco.MjData],
        generators: Sequence[np.random.Generator],
        on_forces: Callable[[], None],
    ) -> None:
        """Prepare one `self` per simulation.

        Args:
            reward: `_get_rew(self, x_velocity, action)`.
            environment: what `self` is a copy of.
            data: of each simulation.
            generators: of each simulation, for rewards that use `self.np_random`.
            on_forces: called once the reward looks at forces that MuJoCo computes only when asked.
        """
        self._reward = reward
        self.terms = TermRecord(len(data))
        self.data = [read_only_data(one, on_forces) for one in data]
        self.inherited = {name: _protect(value) for name, value in vars(environment).items()}
        self.inherited["mujoco_renderer"] = None  # it holds the writable data
        self.inherited["model"] = ReadOnly(environment.model)
        self._fresh = [
            {**self.inherited, "data": one, "_np_random": generator}
            for one, generator in zip(self.data, generators, strict=True)
        ]
        self._selves = [object.__new__(type(environment)) for _ in data]
        for index in range(len(data)):
            self.reset(index)

    def __call__(
        self, simulations: Any, x_velocity: NDArray[np.floating[Any]], actions: Array
    ) -> Array:
        """Return rewards (n,). The slow path reads each simulation's data, not `simulations`."""
        rewards = np.empty(len(self._selves))
        for index in range(len(rewards)):
            rewards[index], terms = self.one(index, x_velocity[index], actions[index])
            self.terms.add(terms)
        return rewards

    def one(
        self, index: int, x_velocity: np.floating[Any], action: Array
    ) -> tuple[float, Mapping[str, Any]]:
        """Return reward and terms of simulation `index`, without recording them.

        Raises:
            RewardFailed: with a diagnosis for the designer.
        """
        try:
            result = self._reward(self._selves[index], x_velocity, action)  # type: ignore[arg-type]
        except (Exception, SystemExit) as error:
            raise self._failed(
                f"raised {self.explain(error)}", index, x_velocity, action
            ) from error
        if type(result) is tuple and len(result) == 2:
            value, terms = as_number(result[0]), result[1]
            if value is not None and math.isfinite(value) and isinstance(terms, Mapping):
                return value, terms
        raise self._failed(_fault(result), index, x_velocity, action)

    def reset(self, index: int) -> None:
        """Forget what the reward kept in the `self` of simulation `index`."""
        attributes = vars(self._selves[index])
        attributes.clear()
        attributes.update(self._fresh[index])

    def statistics(self) -> dict[str, TermStatistics]:
        """Return mean, low and high of each term that was a finite number."""
        return self.terms.statistics()

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the terms' statistics and what the reward keeps in each `self`.

        Raises:
            RewardFailed: the reward keeps something that cannot be written down.
        """
        try:
            kept = [reward_state.dump(self.kept(index)) for index in range(len(self._selves))]
        except TypeError as error:
            raise RewardFailed(f"The reward keeps state that cannot be saved: {error}.") from None
        return {
            **self.terms.state(),
            "kept": np.frombuffer(b"".join(kept), np.uint8),
            "kept_sizes": np.array([len(text) for text in kept], np.int64),
        }

    def restore(self, state: dict[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned."""
        self.terms.restore(state)
        ends = np.cumsum(state["kept_sizes"])
        for index, text in enumerate(np.split(state["kept"], ends[:-1])):
            self.keep(index, reward_state.load(text.tobytes()))

    def keep(self, index: int, kept: Mapping[str, Any]) -> None:
        """Let the `self` of simulation `index` hold `kept`, and nothing else of the reward's."""
        self.reset(index)
        vars(self._selves[index]).update(kept)

    def kept(self, index: int) -> dict[str, Any]:
        """Return what the reward keeps in the `self` of simulation `index`, by name."""
        fresh = self._fresh[index]
        own = vars(self._selves[index]).items()
        return {name: value for name, value in own if fresh.get(name, self) is not value}

    def _failed(self, what: str, index: int, x_velocity: Any, action: Array) -> RewardFailed:
        data = self._fresh[index]["data"]
        state = {
            "qpos": data.qpos,
            "qvel": data.qvel,
            "x_velocity": np.asarray(x_velocity),
            "action": action,
        }
        with np.printoptions(precision=3, suppress=True, threshold=12, linewidth=1000):
            numbers = ", ".join(f"{name} = {value}" for name, value in state.items())
        return RewardFailed(f"The reward {what} in the state {numbers}.")

    def explain(self, error: BaseException) -> str:
        """Return what an exception says, and in which line of the reward it arose."""
        code = getattr(inspect.unwrap(self._reward), "__code__", None)
        files = {REWARD_FILENAME, getattr(code, "co_filename", REWARD_FILENAME)}
        frames = [
            (frame.f_code.co_filename, number)
            for frame, number in traceback.walk_tb(error.__traceback__)
            if frame.f_code.co_filename in files
        ]
        said = f"{type(error).__name__}: {str(error)[:_LONGEST]}"
        if not frames:
            return said
        filename, number = frames[-1]
        return f"{said} (line {number}: `{linecache.getline(filename, number).strip()}`)"


def _protect(value: Any) -> Any:
    if not isinstance(value, np.ndarray):
        return value
    copy = value.copy()
    copy.flags.writeable = False
    return copy


def _fault(result: Any) -> str:
    """Return what is wrong with what a reward returned, in words."""
    wanted = "it must return (reward, terms): a finite number, and a dict of numbers by name;"
    if type(result) is not tuple or len(result) != 2:
        return f"returned {_shown(result)}; {wanted}"
    value, terms = result
    number = as_number(value)
    if number is None:
        return f"returned {_shown(value)} in the place of the number; {wanted}"
    if not isinstance(terms, Mapping):
        return f"returned {_shown(terms)} in the place of the terms; {wanted}"
    return f"was {number} with the terms {_shown(terms)}; it must be finite;"


def _shown(value: Any) -> str:
    if value is None:
        return "None"
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    if isinstance(value, (bool, int, float, str, list, tuple, dict, np.generic)):
        return f"the {type(value).__name__} {value!r:.{_LONGEST}}"
    return f"an object of type {type(value).__name__}"
