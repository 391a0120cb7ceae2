"""Runs a reward after each control step: once per simulation, each with a `self` of its own."""

from __future__ import annotations

import linecache
import math
import traceback
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.missing import MissingAttributes, names_for_rewards
from robomore.envs.random_state import has_spawned
from robomore.envs.read_only import ReadOnly, protect, read_only_data
from robomore.envs.reward_amount import Amount, amount, mark, parts
from robomore.envs.reward_objects import FixedObjects
from robomore.envs.reward_outside import Outside
from robomore.envs.reward_program import REWARD_FILENAME, RewardInstance, RewardProgram
from robomore.envs.reward_restore import load
from robomore.envs.reward_state import UnsavedStateError, dump
from robomore.envs.robots.base import Array, RewardFunction, RobotEnvironment
from robomore.envs.term_record import TermRecord, as_number
from robomore.errors import RewardFailed
from robomore.suggestions import meant
from robomore.types import TermStatistics

_LONGEST = 500
"""Characters of a reward's own words that a diagnosis repeats."""

_NOT_KEPT = (
    "all simulations share and no checkpoint holds; keep it in an attribute of `self`, or in an "
    "object of your own, draw from `self.np_random` alone, and name each combination of members of "
    "an `enum.Flag` in its class"
)

_NAMES = "a name is one line of printable characters;"

_INDEX = "_simulation_index"
"""Attribute of `self` that holds the number of its simulation."""

_DELETED = "_deleted"
"""Name in a checkpoint for the attributes of `self` that the reward took away."""


class RewardRunner:
    """Calls a reward once per simulation and control step.

    `self` is a copy of the robot's environment, so everything that the official class offers is
    there, on data of that simulation which can be read and not changed. What the reward keeps in
    `self` is its own, one per simulation, and gone when an episode ends. What it keeps elsewhere,
    in a list at the top level, say, is also one per simulation, and lasts for the whole training.
    """

    def __init__(
        self,
        reward: RewardFunction,
        environment: RobotEnvironment,
        data: Sequence[mujoco.MjData],
        generators: Sequence[np.random.Generator],
        on_request: Callable[[int], None],
    ) -> None:
        """Prepare one `self` per simulation.

        Args:
            reward: `_get_rew(self, x_velocity, action)`. A `RewardProgram` is executed for each
                simulation; all simulations share any other function, whose own state is not known.
            environment: what `self` is a copy of.
            data: of each simulation.
            generators: of each simulation, for rewards that use `self.np_random`.
            on_request: see `read_only_data`.
        """
        count = len(data)
        self._instances: list[RewardInstance | None] = [None] * count
        self._rewards: list[RewardFunction] = [reward] * count
        if isinstance(reward, RewardProgram):
            instances = [reward.instance() for _ in data]
            self._instances = [*instances]
            self._rewards = [one.function for one in instances]
        self._fixed = [FixedObjects(one) for one in self._instances]
        self._terms = TermRecord()
        self._steps = [0]
        self._health: list[Any] = [True] * count
        self.missing = MissingAttributes()
        self._robot, self._health_type = _robot_class(
            environment, self._health, self._steps, self.missing
        )
        inherited = {name: protect(value) for name, value in vars(environment).items()}
        inherited |= dict.fromkeys(
            ("mujoco_renderer", "_reward", "_control_map")
        )  # they can be changed
        inherited["model"] = ReadOnly(environment.model, constant=True, missing=self.missing)
        inherited["metadata"] = protect(environment.metadata)
        self._outside: Outside | None = None
        self._fresh = [
            {
                **inherited,
                "data": read_only_data(one, on_request, self.missing),
                "_np_random": generator,
                _INDEX: index,
            }
            for index, (one, generator) in enumerate(zip(data, generators, strict=True))
        ]
        self._selves: list[Any] = [object.__new__(self._robot) for _ in data]
        for index in range(count):
            self.reset(index)
        if isinstance(reward, RewardProgram):
            self._outside = Outside(self._robot, inherited.values(), self._fixed)

    def __call__(
        self,
        x_velocity: Array,
        actions: Array,
        healthy: NDArray[np.bool_],
        diverged: NDArray[np.bool_],
    ) -> Array:
        """Return rewards (num_envs,) after a control step.

        Args:
            x_velocity: (num_envs,) in m/s.
            actions: (num_envs, action_size); each reward gets a copy of its own.
            healthy: (num_envs,) what `self.is_healthy` says, where the robot has it.
            diverged: (num_envs,) where there is no state to judge, and the reward is 0.

        Raises:
            RewardFailed: with a diagnosis for the designer.
        """
        self._health[:] = map(self._health_type, healthy)
        record, isfinite = self._terms.add, math.isfinite
        rewards: list[float] = []
        for reward, robot, speed, action, nothing in zip(
            self._rewards, self._selves, x_velocity, actions, diverged, strict=True
        ):
            if nothing:
                rewards.append(0.0)
                continue
            try:
                # A row of the array would lead, by its `base`, to the other simulations.
                result = reward(robot, speed, action.copy())
            except (Exception, SystemExit) as error:
                what = f"raised {self._explain(error)}"
                raise self._failed(what, len(rewards), speed, action) from error
            if type(result) is tuple and len(result) == 2:
                value, terms = as_number(result[0]), result[1]
                if value is not None and isfinite(value) and isinstance(terms, Mapping):
                    try:
                        record(terms)
                    except ValueError as error:
                        said = f"names a term wrongly: {error}; {_NAMES}"
                        raise self._failed(said, len(rewards), speed, action) from None
                    rewards.append(value)
                    continue
            raise self._failed(_fault(result), len(rewards), speed, action)
        self._steps[0] += len(rewards)
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

    def check(self) -> None:
        """Refuse a reward that has changed something that no checkpoint holds.

        Raises:
            RewardFailed: naming it.
        """
        changed = self._outside and self._outside.changed()
        if any(type(one) is not self._robot for one in self._selves):
            changed = "self.__class__"
        spawned = any(has_spawned(fresh["_np_random"]) for fresh in self._fresh)
        if changed or spawned:
            raise RewardFailed(
                f"The reward changes `{changed or 'self.np_random'}`, which {_NOT_KEPT}."
            )

    def amounts(self, index: int) -> dict[str, Amount]:
        """Return how much the reward keeps for one simulation, by name (see `parts`)."""
        instance, fresh = self._instances[index], self._fresh[index]
        if instance is None:
            return {}
        own = vars(self._selves[index])
        kept = {f"self.{k}": one for k, one in own.items() if fresh.get(k, self) is not one}
        return {name: amount(one, instance) for name, one in (kept | parts(instance)).items()}

    def marks(self, index: int) -> dict[str, bytes]:
        """Return a digest of each thing that lasts for the training of one simulation, by name."""
        instance = self._instances[index]
        if instance is None:
            return {}
        return {name: mark(one, instance) for name, one in parts(instance).items()}

    def state(self) -> dict[str, NDArray[Any]]:
        """Return the terms' statistics and what the reward keeps for each simulation.

        Raises:
            RewardFailed: the reward keeps something that cannot be written down.
        """
        self.check()
        kept = [self._dump(index) for index in range(len(self._selves))]
        return {
            **self._terms.state(),
            "steps": np.array(self._steps, np.int64),
            "kept": np.frombuffer(b"".join(kept), np.uint8),
            "kept_sizes": np.array([len(text) for text in kept], np.int64),
        }

    def restore(self, state: dict[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned, before any call.

        Raises:
            RewardFailed: the reward is not the same each time that it is executed.
        """
        self._terms.restore(state)
        self._steps[0] = int(state["steps"][0])
        ends = np.cumsum(state["kept_sizes"])
        for index, text in enumerate(np.split(state["kept"], ends[:-1])):
            self.reset(index)
            fixed, known = self._fixed[index], self._known(index)
            try:
                kept = load(text.tobytes(), self._instances[index], fixed, known)
            except ValueError as error:
                raise RewardFailed(f"The reward cannot be continued: {error}.") from None
            own = vars(self._selves[index])
            for name in kept.pop(_DELETED):
                own.pop(name, None)
            own.update(kept)

    def _dump(self, index: int) -> bytes:
        fresh, own = self._fresh[index], vars(self._selves[index])
        kept = {name: value for name, value in own.items() if fresh.get(name, self) is not value}
        kept[_DELETED] = sorted(fresh.keys() - own.keys())
        instance = self._instances[index]
        try:
            return dump(instance, self._fixed[index], kept, self._known(index))
        except UnsavedStateError as error:
            line = instance.program.line_of(error.name) if instance else 0
            where = f" (line {line})" if line else ""
            raise RewardFailed(f"The reward keeps what cannot be saved: {error}{where}.") from None

    def _known(self, index: int) -> dict[str, Any]:
        """Return what a checkpoint names and does not hold: objects of the simulation."""
        return {**self._fresh[index], "self": self._selves[index]}

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
        code = getattr(self._rewards[0], "__code__", None)
        files = {REWARD_FILENAME, getattr(code, "co_filename", REWARD_FILENAME)}
        frames = [
            (frame.f_code.co_filename, number)
            for frame, number in traceback.walk_tb(error.__traceback__)
            if frame.f_code.co_filename in files
        ]
        said = f"{type(error).__name__}: {str(error)[:_LONGEST]}{meant(error)}"
        if not frames:
            return said
        filename, number = frames[-1]
        return f"{said} (line {number}: `{linecache.getline(filename, number).strip()}`)"


def _robot_class(
    environment: RobotEnvironment,
    health: Sequence[Any],
    steps: Sequence[int],
    missing: MissingAttributes,
) -> tuple[type, Callable[[Any], Any]]:
    """Return a robot's class as rewards see it, and the type of the values of `is_healthy`.

    `training_steps` is read from `steps`, and `is_healthy` from `health`: the official property
    computes anew for one simulation what `VectorEnv` has just computed for all of them, and most
    rewards ask for it. A class that does not say health for many simulations at once keeps its own
    property.
    """
    robot = type(environment)

    def absent(self: Any, name: str) -> Any:
        if name.startswith("__") or hasattr(type(self), name):
            # A property of that name has raised: let it say why once more.
            return object.__getattribute__(self, name)
        raise missing.error("self", name, robot.__name__, lambda: names_for_rewards(self))

    attributes: dict[str, Any] = {
        "training_steps": property(lambda self: steps[0]),
        "__getattr__": absent,
        "__module__": robot.__module__,
        "__doc__": robot.__doc__,
    }
    kind: Callable[[Any], Any] = bool
    official = getattr(robot, "is_healthy", None)
    if robot.judges_health() and isinstance(official, property) and official.fget:
        attributes["is_healthy"] = property(lambda self: health[getattr(self, _INDEX)])
        kind = type(official.fget(environment))
    return type(robot.__name__, (robot,), attributes), kind


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
    parts = {str(name)[:80]: as_number(term) for name, term in terms.items()}
    faulty = [
        f"{name!r} was {part}"
        for name, part in parts.items()
        if part is not None and not math.isfinite(part)
    ]
    which = f" (the term {', '.join(faulty[:3])})" if faulty else ""
    return f"was {number}{which}; it must be finite; it returned {_shown(terms)};"


def _shown(value: Any) -> str:
    if value is None:
        return "None"
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    if isinstance(value, (bool, int, float, str, list, tuple, dict, np.generic)):
        return f"the {type(value).__name__} {value!r:.{_LONGEST}}"
    return f"an object of type {type(value).__name__}"
