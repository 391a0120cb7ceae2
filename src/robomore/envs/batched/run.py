"""One run of a reward for many simulations: what it meets, and how it calls NumPy."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NoReturn

import numpy as np

from robomore.envs.batched.arrays import FUNCTIONS, WRITING
from robomore.envs.batched.value import Batched, Values, lift


class Refused(BaseException):
    """The reward does something that cannot be done for many simulations at once.

    No `Exception`, so that a reward that catches those does not mistake it for its own.
    """


class Divided(BaseException):
    """A condition holds in some simulations and not in others.

    Attributes:
        holds: (m,) bool.
    """

    def __init__(self, holds: Values) -> None:
        super().__init__("simulations differ in a condition")
        self.holds = holds


class Run:
    """What a reward meets on its way, for the `Batched` values that it calculates with.

    Attributes:
        width: simulations of this run.
        outcomes: of each condition so far, in which all simulations agreed.
        trouble: what ends this run, even if the reward catches the exception.
        faults: kinds of floating-point faults (`overflow`, …) so far, if the run is strict.
        strict: whether the program uses numbers of Python, which raise an exception where those of
            NumPy go on with infinity.
    """

    def __init__(self) -> None:
        self.width = 0
        self.outcomes: list[bool] = []
        self.trouble: Refused | Divided | None = None
        self.faults: set[str] = set()
        self.strict = True

    def of(self, width: int, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call `function` for `width` simulations.

        Raises:
            Refused: it tried something that cannot be done for all of them at once.
            Divided: they differ in a condition.
        """
        self.width = width
        self.outcomes.clear()
        self.faults.clear()
        self.trouble = None
        try:
            if not self.strict:
                returned = function(*arguments)
            else:
                with np.errstate(all="call", under="ignore", call=self._note_fault):
                    returned = function(*arguments)
        except BaseException:
            if self.trouble is not None:
                raise self.trouble from None
            raise
        if self.trouble is not None:
            raise self.trouble
        return returned

    def refuse(self, what: str) -> NoReturn:
        """Say that `what` cannot be done for many simulations at once.

        Raises:
            Refused: always.
        """
        refused = Refused(what)
        self.trouble = self.trouble or refused
        raise refused

    def decide(self, holds: Values) -> bool:
        """Return the truth of a condition (m,) that all simulations agree in.

        Raises:
            Divided: they do not.
        """
        first = bool(holds[0])
        if len(holds) > 1 and not (holds.all() if first else not holds.any()):
            divided = Divided(holds.astype(np.bool_))
            self.trouble = self.trouble or divided
            raise divided
        self.outcomes.append(first)
        return first

    def call(self, function: Any, args: Sequence[Any], kwargs: Mapping[str, Any]) -> Any:
        """Return what a function of NumPy returns for each simulation.

        Raises:
            Refused: it writes into its arguments, or returns something else than numbers.
        """
        if isinstance(function, np.ufunc) and function.signature is None and not kwargs:
            result = function(*[lift(argument, self) for argument in args])
            if type(result) is tuple:
                return tuple(Batched(part, self) for part in result)
            return Batched(result, self)
        known = FUNCTIONS.get(function)
        if known is not None and known.takes(args, kwargs):
            result = known.function(self, *args, **kwargs)
            return Batched(result, self) if type(result) is np.ndarray else result
        return self.each(function, args, kwargs)

    def each(
        self, function: Callable[..., Any], args: Sequence[Any], kwargs: Mapping[str, Any]
    ) -> Any:
        """Call `function` once per simulation: slower, and right for any that writes nothing."""
        if function in WRITING or kwargs.get("out") is not None:
            self.refuse(f"`{getattr(function, '__name__', function)}`, which writes into an array")
        return self._joined(
            [
                function(
                    *(_picked(argument, i) for argument in args),
                    **{name: _picked(argument, i) for name, argument in kwargs.items()},
                )
                for i in range(self.width)
            ]
        )

    def _joined(self, results: Sequence[Any]) -> Any:
        """Return the results of all simulations as one."""
        first = results[0]
        if isinstance(first, (tuple, list)):
            if any(len(result) != len(first) for result in results):
                self.refuse("a result whose length differs between simulations")
            return [self._joined(parts) for parts in zip(*results, strict=True)]
        arrays = [np.asarray(result) for result in results]
        if arrays[0].dtype.hasobject or any(a.shape != arrays[0].shape for a in arrays):
            self.refuse("a result whose shape differs between simulations")
        return Batched(np.stack(arrays, axis=-1), self)

    def _note_fault(self, kind: str, flag: int) -> None:
        self.faults.add(kind)


def _picked(value: Any, index: int) -> Any:
    """Return what `value` is in one simulation."""
    if type(value) is Batched:
        return value.values[..., index].copy() if value.ndim else value.values[index]
    if type(value) in (list, tuple):
        return type(value)(_picked(item, index) for item in value)
    if type(value) is deque:
        return deque((_picked(item, index) for item in value), value.maxlen)
    return value
