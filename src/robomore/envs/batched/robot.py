"""`self` of a reward that runs for many simulations: the official class on the data of them all."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from types import FunctionType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.envs.batched.names import StandIns
from robomore.envs.batched.run import Run
from robomore.envs.batched.value import Batched, Values
from robomore.envs.gather import Gather
from robomore.envs.read_only import ReadOnly
from robomore.envs.robots.base import Array


def batched_class(robot: type, run: Run, stand_ins: StandIns) -> type:
    """Return the class of a `self` for many simulations: `robot`, so that all its code is there.

    What a reward may call for runs with the same stand-ins for NumPy as the reward, which is not
    necessary but faster. `is_healthy` is what an instance holds under that name, since the official
    code asks for it in conditions. Random numbers are refused: each simulation has its own.
    """
    attributes: dict[str, Any] = {
        "__module__": robot.__module__,
        "np_random": property(lambda self: run.refuse("random numbers")),
    }
    if hasattr(robot, "is_healthy"):
        attributes["is_healthy"] = None
    for name in dir(robot):
        member = inspect.getattr_static(robot, name)
        if name in attributes:
            continue
        if isinstance(member, FunctionType):
            attributes[name] = _with_stand_ins(member, stand_ins)
        elif isinstance(member, property) and isinstance(member.fget, FunctionType):
            attributes[name] = property(_with_stand_ins(member.fget, stand_ins))
    return type(f"Batched{robot.__name__}", (robot,), attributes)


def _with_stand_ins(function: FunctionType, stand_ins: StandIns) -> FunctionType:
    names = {name: function.__globals__.get(name) for name in function.__code__.co_names}
    if names.get("np") is not np:
        return function
    return FunctionType(
        function.__code__,
        {**function.__globals__, "np": stand_ins.module(np)},
        function.__name__,
        function.__defaults__,
        function.__closure__,
    )


class Clock:
    """Counts steps, so that what was read in an earlier one is known to be out of date."""

    def __init__(self) -> None:
        self.step = 0


class BatchedData:
    """The same struct of all simulations as one: `MjData`, or a part such as `data.body("torso")`.

    As in MuJoCo, an array is always the same one and holds the newest numbers. It is read when the
    reward first asks for it in a step.
    """

    def __init__(
        self,
        parts: Sequence[ReadOnly],
        run: Run,
        clock: Clock,
        live: Callable[[str], Array | None] = lambda name: None,
    ) -> None:
        """Make one of `parts`.

        Args:
            parts: of each simulation.
            run: what the numbers are calculated with.
            clock: the step.
            live: returns an array (n, …) that is up to date in every step, by its name.
        """
        vars(self).update(_parts=parts, _run=run, _clock=clock, _live=live, _readers={})

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        reader = self._readers.get(name)
        if reader is None:
            found = [getattr(part, name) for part in self._parts]
            fixed = self._fixed(name, found)
            if fixed is not None:
                vars(self)[name] = fixed
                return fixed
            reader = self._readers[name] = self._reader(name, found)
        return reader()

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a reward may read `{name}` of the simulation, but not set it")

    def _fixed(self, name: str, found: Sequence[Any]) -> Any:
        """Return what `name` is in every step, if it is always the same object."""
        first, live = found[0], self._live(name)
        if live is not None:
            return Batched(_read_only(np.moveaxis(live, 0, -1)), self._run)
        if isinstance(first, ReadOnly):
            return BatchedData(found, self._run, self._clock)
        if isinstance(first, str):
            return first
        return _Method(found, self._run, self._clock) if callable(first) else None

    def _reader(self, name: str, found: Sequence[Any]) -> Callable[[], Batched]:
        """Return a function that returns what `name` is now."""
        if isinstance(found[0], (float, int)):
            return lambda: Batched(np.array([getattr(p, name) for p in self._parts]), self._run)
        # Only an array that stays where it is has been kept by its `ReadOnly`.
        if not all(
            name in vars(part) and one.flags.c_contiguous and one.dtype == np.float64
            for part, one in zip(self._parts, found, strict=True)
        ):
            self._run.refuse(f"`{name}` of the simulation, which is not always there")
        gather = Gather([[one.reshape(-1)] for one in found])
        values = gather.values.reshape(len(found), *found[0].shape)
        batched = Batched(_read_only(np.moveaxis(values, 0, -1)), self._run)
        clock, last = self._clock, -1

        def read() -> Batched:
            nonlocal last
            if last != clock.step:
                last = clock.step
                gather.read()
            return batched

        return read


class Selected:
    """A `BatchedData` of some of the simulations, for one run."""

    def __init__(self, whole: Any, rows: NDArray[np.intp]) -> None:
        vars(self).update(_whole=whole, _rows=rows)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        selected = vars(self)[name] = self._of(getattr(self._whole, name))
        return selected

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a reward may read `{name}` of the simulation, but not set it")

    def __call__(self, *arguments: Any) -> Any:
        return self._of(self._whole(*arguments))

    def _of(self, value: Any) -> Any:
        if type(value) is Batched:
            return Batched(_read_only(value.values[..., self._rows]), value.run)
        return value if isinstance(value, str) else Selected(value, self._rows)


class _Method:
    """`data.body`, `data.joint`, …: what they return for a name, for all simulations."""

    def __init__(self, methods: Sequence[Callable[..., Any]], run: Run, clock: Clock) -> None:
        self._methods = methods
        self._run = run
        self._clock = clock
        self._found: dict[Any, BatchedData] = {}

    def __call__(self, *arguments: Any) -> BatchedData:
        if arguments not in self._found:
            parts = [method(*arguments) for method in self._methods]
            if not isinstance(parts[0], ReadOnly):
                self._run.refuse("a method of the simulation that returns no part of it")
            self._found[arguments] = BatchedData(parts, self._run, self._clock)
        return self._found[arguments]


def _read_only(values: Values) -> Values:
    view = values.view()
    view.flags.writeable = False
    return view
