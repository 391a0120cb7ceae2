"""A reward as a program: compiled once, and executed anew for each simulation.

Each execution is a module of its own. So what a reward keeps in a list at the top level, in a
default argument or in a closure belongs to one simulation, as what it keeps in `self` does.
"""

from __future__ import annotations
import __future__

import ast
import linecache
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from types import CodeType, ModuleType
from typing import TYPE_CHECKING, Any

from robomore.envs.reward_imports import BUILTINS, offered_modules
from robomore.errors import InvalidReward

if TYPE_CHECKING:
    from robomore.envs.robots.base import Array, RewardFunction

REWARD_FILENAME = "<reward>"
"""The name under which a reward's text is compiled, and its lines stand in tracebacks."""

NAME = "_get_rew"

MODULE = "_robomore_reward"
"""`__name__` of each module; not a name that somebody would import."""


@dataclass(frozen=True, slots=True)
class RewardInstance:
    """A reward that was executed for one simulation.

    Attributes:
        function: its `_get_rew`, to be called.
        namespace: names and values at its top level.
        program: the reward that was executed.
    """

    function: RewardFunction
    namespace: dict[str, Any]
    program: RewardProgram

    def names(self) -> dict[str, Any]:
        """Return what the namespace holds, without Python's own."""
        return {name: value for name, value in self.namespace.items() if name != "__builtins__"}


class RewardProgram:
    """The text of a reward; a `RewardFunction` itself, whose calls share one instance.

    Attributes:
        source: the text.
        codes: code of all functions in it, in the order of the text.
    """

    def __init__(
        self,
        source: str,
        names: Mapping[str, Any] | None = None,
        watched: Callable[[], AbstractContextManager[None]] = nullcontext,
        watch: Callable[[RewardFunction], RewardFunction] = lambda function: function,
    ) -> None:
        """Compile `source`, which is not executed yet.

        Args:
            source: program text that defines `_get_rew(self, x_velocity, action)`.
            names: that are there without an import, besides `np`, `numpy` and `math`.
            watched: entered while the top level is executed.
            watch: given the function of each instance; returns what is called in its place.

        Raises:
            InvalidReward: the text does not compile.
        """
        # A mark of the byte order belongs to a file, not to its text.
        self.source = source = source.removeprefix("\ufeff")
        linecache.cache[REWARD_FILENAME] = (
            len(source),
            None,
            source.splitlines(keepends=True),
            REWARD_FILENAME,
        )
        flags = __future__.annotations.compiler_flag
        try:
            code = compile(source, REWARD_FILENAME, "exec", flags=flags, dont_inherit=True)
        except SyntaxError as error:
            raise InvalidReward(f"line {error.lineno}: does not parse: {error.msg}") from None
        except (ValueError, RecursionError, MemoryError, OverflowError) as error:
            said = f"{type(error).__name__}: {error}"
            raise InvalidReward(f"does not parse: {said}") from None
        self._code = code
        modules = offered_modules()
        self._names = {
            "__builtins__": BUILTINS,
            "np": modules["numpy"],
            "numpy": modules["numpy"],
            "math": modules["math"],
            **(names or {}),
        }
        self._watched, self._watch = watched, watch
        self._shared: RewardInstance | None = None
        self.codes = tuple(_inner_codes(code))
        self._places = {id(inner): place for place, inner in enumerate(self.codes)}

    def instance(self) -> RewardInstance:
        """Execute the text; returns a new instance.

        Raises:
            InvalidReward: it defines no `_get_rew`.
            BaseException: whatever the text raises.
        """
        module = ModuleType(MODULE)
        namespace = vars(module)
        namespace.update(self._names)
        # Dataclasses look up the module of their annotations.
        before = sys.modules.get(MODULE)
        sys.modules[MODULE] = module
        try:
            with self._watched():
                exec(self._code, namespace)
        finally:
            if before is None:
                sys.modules.pop(MODULE, None)
            else:
                sys.modules[MODULE] = before
        function = namespace.get(NAME)
        if not callable(function):
            raise InvalidReward(f"defines no function `{NAME}(self, x_velocity, action)`")
        return RewardInstance(self._watch(function), namespace, self)

    def __call__(
        self, robot: Any, x_velocity: float, action: Array
    ) -> tuple[float, Mapping[str, float]]:
        """Call the one instance that all such calls share."""
        if self._shared is None:
            self._shared = self.instance()
        return self._shared.function(robot, x_velocity, action)

    def place(self, code: CodeType) -> int | None:
        """Return the place of a function's code in `codes`, `None` if it is not of this text."""
        return self._places.get(id(code))

    def __reduce__(self) -> tuple[Any, ...]:
        """Return how a copy is made: from the text, since each process executes it anew."""
        return RewardProgram, (self.source,)

    def line_of(self, name: str) -> int:
        """Return the line in which `name` (or `self.name`) first gets a value, else 1."""
        for node in ast.walk(ast.parse(self.source)):
            match node:
                case (
                    ast.Name(id=found, ctx=ast.Store())
                    | ast.Attribute(attr=found, ctx=ast.Store())
                    | ast.FunctionDef(name=found)
                    | ast.ClassDef(name=found)
                    | ast.arg(arg=found)
                ) if found == name:
                    return node.lineno
        return 1


def _inner_codes(code: CodeType) -> Iterator[CodeType]:
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield constant
            yield from _inner_codes(constant)
