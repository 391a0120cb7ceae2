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
"""Characters of a reward's own words that a diagnosis repeats."""

_INDEX = "_simulation_index"
"""Attribute of `self` that holds the number of its simulation."""


class RewardRunner:
    """Calls a reward once per simulation and control step.

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
        self._terms = TermRecord()
        self._health: list[Any] = [True] * len(data)
        robot, self._health_type = _with_known_health(environment, self._health)
        inherited = {name: _protect(value) for name, value in vars(environment).items()}
        inherited["mujoco_renderer"] = None  # it holds the writable data
        inherited["model"] = ReadOnly(environment.model, constant=True)
        self._fresh = [
            {
                **inherited,
                "data": read_only_data(one, on_forces),
                "_np_random": generator,
                _INDEX: index,
            }
            for index, (one, generator) in enumerate(zip(data, generators, strict=True))
        ]
        self._selves: list[Any] = [object.__new__(robot) for _ in data]
        for index in range(len(data)):
            self.reset(index)

    def __call__(self, x_velocity: Array, actions: Array, healthy: NDArray[np.bool_]) -> Array:
        """Return rewards (num_envs,) after a control step.

        Args:
            x_velocity: (num_envs,) in m/s.
            actions: (num_envs, action_size); the reward may change them.
            healthy: (num_envs,) what `self.is_healthy` says, where the robot has it.

        Raises:
            RewardFailed: with a diagnosis for the designer.
        """
        self._health[:] = map(self._health_type, healthy)
        reward, record, isfinite = self._reward, self._terms.add, math.isfinite
        rewards: list[float] = []
        for robot, speed, action in zip(self._selves, x_velocity, actions, strict=True):
            try:
                result = reward(robot, speed, action)
            except (Exception, SystemExit) as error:
                what = f"raised {self._explain(error)}"
                raise self._failed(what, len(rewards), speed, action) from error
            if type(result) is tuple and len(result) == 2:
                value, terms = as_number(result[0]), result[1]
                if value is not None and isfinite(value) and isinstance(terms, Mapping):
                    rewards.append(value)
                    record(terms)
                    continue
            raise self._failed(_fault(result), len(rewards), speed, action)
        return np.array(rewards)

    def reset(self, index: int) -> None:
        """Forget what the reward kept in the `self` of simulation `index`."""
        attributes = vars(self._selves[index])
        attributes.clear()
        attributes.update(self._fresh[index])

    def statistics(self) -> dict[str, TermStatistics]:
        """Return mean, low and high of each term that was a finite number."""
        return self._terms.statistics()

    def sums(self) -> dict[str, tuple[int, float]]:
        """Return, for each term, how many finite values it had so far, and their sum."""
        return self._terms.sums()

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
            **self._terms.state(),
            "kept": np.frombuffer(b"".join(kept), np.uint8),
            "kept_sizes": np.array([len(text) for text in kept], np.int64),
        }

    def restore(self, state: dict[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned."""
        self._terms.restore(state)
        ends = np.cumsum(state["kept_sizes"])
        for index, text in enumerate(np.split(state["kept"], ends[:-1])):
            self.reset(index)
            vars(self._selves[index]).update(reward_state.load(text.tobytes()))

    def _kept(self, index: int) -> dict[str, Any]:
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

    def _explain(self, error: BaseException) -> str:
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


def _with_known_health(
    environment: RobotEnvironment, health: Sequence[Any]
) -> tuple[type, Callable[[Any], Any]]:
    """Return a robot's class whose `is_healthy` is read from `health`, and the type of its values.

    The official property computes anew for one simulation what `VectorEnv` has just computed for
    all of them, and most rewards ask for it. A class that does not say health for many
    simulations at once keeps its own property.
    """
    robot = type(environment)
    official = getattr(robot, "is_healthy", None)
    if not (robot.judges_health() and isinstance(official, property) and official.fget):
        return robot, bool
    known = property(lambda self: health[getattr(self, _INDEX)])
    attributes = {"is_healthy": known, "__module__": robot.__module__, "__doc__": robot.__doc__}
    return type(robot.__name__, (robot,), attributes), type(official.fget(environment))


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
