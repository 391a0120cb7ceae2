"""Runs a reward after each control step: once for all simulations, if that gives the same numbers.

VectorEnv are parted where a condition of the reward holds in some of them only, and where what it
keeps in `self` differs in form, and run as so many groups. A reward that takes a new way through
its program also runs once per simulation, and both must agree. If they do not, or if it does what
cannot be done for many simulations at once, it runs once per simulation from then on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from robomore.envs.batched import group as batched_group
from robomore.envs.batched import state as batched_state
from robomore.envs.batched.check import Result, difference
from robomore.envs.batched.function import batched_function
from robomore.envs.batched.group import Group
from robomore.envs.batched.robot import BatchedData, Clock, Selected, batched_class
from robomore.envs.batched.run import Divided, Refused, Run
from robomore.envs.batched.trust import Trust
from robomore.envs.batched.value import Batched, Values
from robomore.envs.reward_runner import PerSimulationReward
from robomore.envs.robots.base import Array, RewardFunction, RobotEnvironment
from robomore.envs.term_record import as_number
from robomore.types import TermStatistics

Truths = list[tuple[float, Mapping[str, Any]]]


class BatchedReward:
    """Gives the rewards of all simulations after one control step.

    What it returns and records are the numbers of the run for all, which differ from those per
    simulation by rounding at most (see `check`). A reward that fails is left to fail per
    simulation, where the diagnosis is made.
    """

    def __init__(
        self,
        reward: RewardFunction,
        environment: RobotEnvironment,
        data: Sequence[mujoco.MjData],
        generators: Sequence[np.random.Generator],
        on_forces: Callable[[], None],
        live: Mapping[str, Array],
        allowed: bool = True,
    ) -> None:
        """Prepare both ways to run.

        Args:
            reward: `_get_rew(self, x_velocity, action)`.
            environment: what `self` is a copy of.
            data: of each simulation.
            generators: of each simulation, for rewards that use `self.np_random`.
            on_forces: called once the reward looks at forces that MuJoCo computes only when asked.
            live: arrays (n, …) of the data that are up to date after every step, by name.
            allowed: whether it may run for all simulations at once.
        """
        self._single = PerSimulationReward(reward, environment, data, generators, on_forces)
        self._n = len(data)
        self._run = Run()
        self._clock = Clock()
        self._data = BatchedData(self._single.data, self._run, self._clock, live.get)
        self._fresh: dict[str, Any] = {**self._single.inherited, "data": self._data}
        self._everyone = Group(np.arange(self._n), {})
        self._call: Callable[[Any, Any, Any], Any] = reward
        self._keeps = False
        self._never = "" if allowed else "as was asked for"
        if allowed:
            try:
                self._prepare(reward, type(environment))
            except Refused as refused:
                self._never = f"it uses {refused}"
        self.begin()

    def _prepare(self, reward: RewardFunction, robot: type) -> None:
        function = batched_function(reward, self._run)
        self._call, self._keeps = function.call, function.keeps
        self._run.strict = function.plain
        self._self: Any = object.__new__(batched_class(robot, self._run, function.stand_ins))
        self._self.__dict__.update(self._fresh)
        self._asks_health = hasattr(robot, "is_healthy")

    def begin(self) -> None:
        """Start anew in all simulations, and forget what was found out about the reward."""
        self._trust = Trust(self._n, self._never)
        self._groups = [self._everyone]
        self._started: set[int] = set()
        # In which simulations `self` has seen every step; what the others keep, their group knows.
        self._followed = np.ones(self._n, np.bool_)
        for index in range(self._n):
            self._single.reset(index)

    def __call__(
        self, simulations: Any, x_velocity: NDArray[np.floating[Any]], actions: Array
    ) -> Array:
        """Return rewards (n,).

        Args:
            simulations: the `VectorEnv` that have just been stepped.
            x_velocity: (n,) in m/s.
            actions: (n, nu) as they were applied.

        Raises:
            RewardFailed: with a diagnosis for the designer.
        """
        if self._trust.why:
            return self._single(simulations, x_velocity, actions)
        self._clock.step += 1
        if self._started:
            self._admit_started()
        rewards = np.empty(self._n)
        done: list[Group] = []
        results: list[Result] = []
        waiting = list(self._groups)
        runs = 0
        while waiting:
            group = waiting.pop()
            runs += 1
            try:
                result = self._result(group, simulations.healthy, x_velocity, actions)
            except Divided as divided:
                parts = (divided.holds, ~divided.holds)
                waiting += [group.of(np.flatnonzero(part)) for part in parts]
                continue
            except (Exception, SystemExit, Refused) as error:  # noqa: BLE001  # a stranger's program
                truths: Truths | None = self._truths(group, x_velocity, actions)
                self._note(error)
            else:
                truths = self._checked(group, result, x_velocity, actions)
            if truths is None:
                rewards[slice(None) if group is self._everyone else group.rows] = result.rewards
                results.append(result)
                done.append(result.after)
                continue
            for row, (value, terms) in zip(group.rows, truths, strict=True):
                rewards[row] = value
                self._single.terms.add(terms)
            done += self._taken_over(group)
        self._record(results)
        self._trust.note_step(runs)
        self._form_groups(done)
        return rewards

    def reset(self, index: int) -> None:
        """Forget what the reward kept in the `self` of simulation `index`."""
        self._single.reset(index)
        self._followed[index] = True
        if self._keeps:
            self._started.add(index)

    def statistics(self) -> dict[str, TermStatistics]:
        """Return mean, low and high of each term over all steps so far."""
        return self._single.statistics()

    def sums(self) -> dict[str, tuple[int, float]]:
        """Return, for each term, how many finite values it had so far, and their sum."""
        return self._single.terms.sums()

    @property
    def note(self) -> str:
        """How the reward ran."""
        return self._trust.note

    def state(self) -> dict[str, NDArray[Any]]:
        """Return everything needed to continue exactly, as arrays.

        Raises:
            RewardFailed: the reward keeps something that cannot be written down.
        """
        if self._started:
            self._admit_started()
        groups = [] if self._trust.why else self._groups
        for index in np.flatnonzero(~self._followed).tolist():
            self._single.reset(index)
        return {
            **self._single.state(),
            "groups": np.frombuffer(batched_group.dump(groups), np.uint8),
            "trust": self._trust.state(),
            "followed": self._followed.copy(),
        }

    def restore(self, state: dict[str, NDArray[Any]]) -> None:
        """Continue from what `state` returned."""
        self._single.restore(state)
        self._trust.restore(state["trust"])
        self._groups = batched_group.load(state["groups"].tobytes(), self._run)
        self._followed = state["followed"].copy()
        self._started.clear()

    def _result(self, group: Group, healthy: Values, x_velocity: Values, actions: Array) -> Result:
        """Run the reward for one group.

        Raises:
            Divided: a condition does not hold in all of its simulations.
            Refused: it does what cannot be done for many simulations at once.
            FloatingPointError: there were numbers that are not finite.
        """
        run, rows = self._run, group.rows
        width = len(rows)
        own = self._self.__dict__
        if self._keeps:
            own.clear()
            own.update(self._fresh)
            for name, value in group.kept.items():
                own[name] = batched_state.copied(value)
        if width == self._n:
            own["data"] = self._data
        else:
            own["data"] = Selected(self._data, rows)
            x_velocity, healthy, actions = x_velocity[rows], healthy[rows], actions[rows]
        if self._asks_health:
            own["is_healthy"] = Batched(healthy, run)
        # A copy: what the reward does to its action must not reach another run.
        action = Batched(actions.T.copy(), run)
        returned = run.of(width, self._call, self._self, Batched(x_velocity, run), action)
        if type(returned) is not tuple or len(returned) != 2 or not hasattr(returned[1], "items"):
            raise TypeError("a reward returns (reward, terms)")
        rewards = _numbers(returned[0], width)
        if run.faults or not math.isfinite(rewards.dot(rewards)):
            raise FloatingPointError("a number is not finite")
        terms = {name: _term(term) for name, term in returned[1].items()}
        if not self._keeps:
            return Result(rewards, terms, group, ((), tuple(run.outcomes)))
        kept = {
            name: value
            for name, value in own.items()
            if self._fresh.get(name, self) is not value and name not in ("data", "is_healthy")
        }
        after = batched_group.group(rows, kept, run)
        return Result(rewards, terms, after, (group.form, tuple(run.outcomes)))

    def _checked(
        self, group: Group, result: Result, x_velocity: Values, actions: Array
    ) -> Truths | None:
        """Compare a result where its way is not trusted; return what is right if it is wrong."""
        if not self._trust.wants_check(result.way):
            if self._keeps:
                self._followed[group.rows] = False
            return None
        truths = self._truths(group, x_velocity, actions)
        kept = [self._single.kept(row) for row in group.rows.tolist()]
        wrong = difference(result, truths, kept)
        if not wrong:
            return None
        self._trust.give_up(f"for the whole batch, {wrong} came out different")
        return truths

    def _truths(self, group: Group, x_velocity: Values, actions: Array) -> Truths:
        """Run the reward once for each simulation of a group.

        Raises:
            RewardFailed: with a diagnosis for the designer.
        """
        truths = []
        for position, row in enumerate(group.rows.tolist()):
            if not self._followed[row]:
                self._single.keep(row, group.at(position))
                self._followed[row] = True
            truths.append(self._single.one(row, x_velocity[row], actions[row]))
        return truths

    def _note(self, error: BaseException) -> None:
        """Draw conclusions from a run that failed though the reward is right per simulation."""
        if self._run.faults or isinstance(error, FloatingPointError):
            self._trust.note_stray()
        elif isinstance(error, Refused):
            what = self._single.explain(error).removeprefix("Refused: ")
            self._trust.give_up(f"it uses {what}")
        else:
            self._trust.give_up(f"for the whole batch, it raised {self._single.explain(error)}")

    def _taken_over(self, group: Group) -> list[Group]:
        """Return simulations that ran one by one, as groups."""
        if self._trust.why or not self._keeps:
            return [group]
        try:
            return [
                batched_group.group(np.array([row]), self._single.kept(row), self._run)
                for row in group.rows.tolist()
            ]
        except Refused as refused:
            self._trust.give_up(f"it uses {refused}")
            return [group]

    def _record(self, results: Sequence[Result]) -> None:
        """Record the terms of one step."""
        if len(results) == 1 and len(results[0].rewards) == self._n:
            self._single.terms.add_step(results[0].terms)
        elif results:
            terms = {name: np.full(self._n, math.nan) for one in results for name in one.terms}
            for one in results:
                for name, values in one.terms.items():
                    terms[name][one.after.rows] = values
            self._single.terms.add_step(terms)

    def _form_groups(self, done: list[Group]) -> None:
        """End a step, after which the simulations are the groups `done`."""
        if self._trust.why:
            for group in done:
                for position, row in enumerate(group.rows.tolist()):
                    if not self._followed[row]:
                        self._single.keep(row, group.at(position))
            self._followed[:] = True
        elif self._keeps:
            self._groups = done if len(done) == 1 else batched_group.joined(done, self._run)

    def _admit_started(self) -> None:
        """Put simulations whose episode has begun into a group of their own."""
        if not self._trust.why:
            started = np.array(sorted(self._started))
            groups = batched_group.without(self._groups, started)
            groups.append(Group(started, {}))
            self._groups = batched_group.joined(groups, self._run)
        self._started.clear()


def _numbers(reward: Any, width: int) -> Values:
    if type(reward) is Batched:
        return reward.number()
    number = as_number(reward)
    if number is None:
        raise TypeError("a reward is a number")
    return np.full(width, number)


def _term(term: Any) -> Any:
    """Return a term's numbers (m,), or what it is in all simulations; NaN if it is no number."""
    if type(term) is not Batched:
        number = as_number(term)
        return math.nan if number is None else number
    if term.ndim:
        return term.number().copy() if term.size == 1 else math.nan
    return term.values
