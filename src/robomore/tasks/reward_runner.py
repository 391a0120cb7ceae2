"""Runs a reward after each control step: once per simulation, each with a `self` of its own."""

from __future__ import annotations

import inspect
import json
import linecache
import math
import traceback
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.errors import RewardFailed
from robomore.tasks import reward_state
from robomore.tasks.environments.base import Array, RewardFunction, RobotEnvironment
from robomore.tasks.read_only import ReadOnly, read_only_data
from robomore.types import TermStatistics

REWARD_FILENAME = "<reward>"
"""The name under which a reward's text is compiled, and its lines stand in tracebacks."""

_MOST_TERMS = 64
"""Terms beyond so many are not recorded: names made up in every step must not fill the memory."""

_LONGEST = 500
"""Characters of a stranger's own words that a diagnosis repeats."""


class RewardRunner(Protocol):
    """Gives the rewards of all simulations after one control step."""

    def __call__(
        self, simulations: Any, x_velocity: NDArray[np.floating[Any]], actions: Array
    ) -> Array:
        """Return rewards (n,).

        Args:
            simulations: the `Simulations` that have just been stepped.
            x_velocity: (n,) in m/s.
            actions: (n, nu) as they were applied.

        Raises:
            RewardFailed: with a diagnosis for the designer.
        """
        ...

    def reset(self, index: int) -> None:
        """An episode of simulation `index` begins: forget what the reward kept of the last one."""
        ...

    def statistics(self) -> dict[str, TermStatistics]:
        """Return mean, low and high of each term over all steps so far."""
        ...

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything needed to continue exactly, as arrays."""
        ...

    def restore(self, state: dict[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned."""
        ...


class PerSimulationReward:
    """The slow path that is always right: one call per simulation and step.

    `self` is a copy of the robot's environment, so everything that the official class offers is
    there, on data of that simulation which can be read and not changed. What the reward keeps in
    `self` is its own, one per simulation, and gone when an episode ends.
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
        self._terms: dict[str, list[float]] = {}  # name -> count, sum, low, high
        model = ReadOnly(environment.model)
        inherited = {name: _protect(value) for name, value in vars(environment).items()}
        inherited["mujoco_renderer"] = None  # it holds the writable data
        self._fresh = [
            {
                **inherited,
                "model": model,
                "data": read_only_data(one, on_forces),
                "_np_random": generator,
            }
            for one, generator in zip(data, generators, strict=True)
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
            rewards[index] = self._call(index, x_velocity[index], actions[index])
        return rewards

    def reset(self, index: int) -> None:
        """Forget what the reward kept in the `self` of simulation `index`."""
        attributes = vars(self._selves[index])
        attributes.clear()
        attributes.update(self._fresh[index])

    def statistics(self) -> dict[str, TermStatistics]:
        """Return mean, low and high of each term that was a finite number."""
        return {
            name: TermStatistics(total / count, low, high)
            for name, (count, total, low, high) in self._terms.items()
        }

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the terms' statistics and what the reward keeps in each `self`.

        Raises:
            RewardFailed: the reward keeps something that cannot be written down.
        """
        try:
            kept = [reward_state.dump(self._kept(index)) for index in range(len(self._selves))]
        except TypeError as error:
            raise RewardFailed(f"The reward keeps state that cannot be saved: {error}.") from None
        return {
            "terms": np.frombuffer(json.dumps(list(self._terms)).encode(), np.uint8),
            "statistics": np.array(list(self._terms.values())).reshape(-1, 4),
            "kept": np.frombuffer(b"".join(kept), np.uint8),
            "kept_sizes": np.array([len(text) for text in kept], np.int64),
        }

    def restore(self, state: dict[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned."""
        names = json.loads(state["terms"].tobytes())
        self._terms = dict(zip(names, state["statistics"].tolist(), strict=True))
        ends = np.cumsum(state["kept_sizes"])
        for index, text in enumerate(np.split(state["kept"], ends[:-1])):
            self.reset(index)
            vars(self._selves[index]).update(reward_state.load(text.tobytes()))

    def _kept(self, index: int) -> dict[str, Any]:
        fresh = self._fresh[index]
        own = vars(self._selves[index]).items()
        return {name: value for name, value in own if fresh.get(name, self) is not value}

    def _call(self, index: int, x_velocity: float, action: Array) -> float:
        try:
            result = self._reward(self._selves[index], x_velocity, action)
        except (Exception, SystemExit) as error:
            raise self._failed(
                f"raised {self._explain(error)}", index, x_velocity, action
            ) from error
        if type(result) is tuple and len(result) == 2:
            value, terms = _number(result[0]), result[1]
            if value is not None and math.isfinite(value) and isinstance(terms, Mapping):
                self._record(terms)
                return value
        raise self._failed(_fault(result), index, x_velocity, action)

    def _record(self, terms: Mapping[str, Any]) -> None:
        for name, term in terms.items():
            value = _number(term)
            if value is None or not math.isfinite(value):
                continue
            known = self._terms.get(name)
            if known is not None:
                known[0] += 1
                known[1] += value
                known[2] = min(known[2], value)
                known[3] = max(known[3], value)
            elif isinstance(name, str) and len(self._terms) < _MOST_TERMS:
                self._terms[name] = [1, value, value, value]

    def _failed(self, what: str, index: int, x_velocity: float, action: Array) -> RewardFailed:
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

    def _explain(self, error: BaseException) -> str:
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


def _number(value: Any) -> float | None:
    """Return `value` as a float where it is one number, bare or in an array of size 1."""
    if type(value) is float:
        return value
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.item()
    if isinstance(value, (int, float, np.integer, np.floating, np.bool_)):
        try:
            return float(value)
        except OverflowError:
            return None
    return None


def _fault(result: Any) -> str:
    """Return what is wrong with what a reward returned, in words."""
    wanted = "it must return (reward, terms): a finite number, and a dict of numbers by name;"
    if type(result) is not tuple or len(result) != 2:
        return f"returned {_shown(result)}; {wanted}"
    value, terms = result
    number = _number(value)
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
