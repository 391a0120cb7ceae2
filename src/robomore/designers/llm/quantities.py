"""Reads the parameters of a morphology in the forms in which models write them.

A value is a number, a text such as `20 cm`, or an object with `value` and `unit`. A unit is
converted to the parameter's own if it measures the same. Any other unit is refused.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from robomore.tasks.task import Parameter, Task

_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?")
_QUANTITY = re.compile(rf"({_NUMBER.pattern})\s*([^\W\d][^\d,;]{{0,30}}|[°%(\[][^\d,;]{{0,30}})?")
_WRAPPERS = ("parameters", "values", "value")
_NAMES = ("name", "parameter", "key", "id")
_PER_UNIT: tuple[Mapping[str, float], ...] = (
    {"m": 1, "meter": 1, "metre": 1, "dm": 10, "cm": 100, "centimeter": 100, "centimetre": 100}
    | {"mm": 1000, "millimeter": 1000, "millimetre": 1000},
    {"rad": 1, "radian": 1, "°": 180 / math.pi, "deg": 180 / math.pi, "degree": 180 / math.pi},
    {"kg": 1, "kilogram": 1, "g": 1000, "gram": 1000},
    {"N·m": 1, "N*m": 1, "Nm": 1, "N m": 1, "mN·m": 1000},
    {"": 1, "1": 1, "-": 1, "count": 1, "none": 1, "dimensionless": 1, "unitless": 1},
)
"""Units of one dimension, and how many of each make the first."""


class NoNumber(Exception):
    """A parameter has no value that can be used. The message names it."""


def read_parameters(answer: Mapping[str, Any], task: Task) -> dict[str, float] | list[float]:
    """Return the numbers of an answer's `parameters`, in the units of the task.

    Args:
        answer: with `parameters`: values by name, a list of values in the task's order, or a list
            of objects with `name` and `value`. `unit` or `units` beside it holds for all of them.
        task: its parameters have names and units.

    Raises:
        NoNumber: a value is no number, or in a unit that is not the parameter's own.
    """
    given, unit = answer["parameters"], _unit_of(answer)
    while isinstance(given, dict) and (inner := _wrapped(given, task.names)) is not None:
        given, unit = inner, _unit_of(given) or unit
    if isinstance(given, list | tuple):
        given = _by_name(given)
    parameters = {one.name: one for one in task.parameters}
    if isinstance(given, dict):
        named = {str(name): value for name, value in given.items()}
        return {n: _number(n, value, parameters.get(n), unit) for n, value in named.items()}
    if isinstance(given, list | tuple):
        own = [*task.parameters, *[None] * len(given)]
        return [
            _number(f"number {i}", value, parameter, unit)
            for i, (value, parameter) in enumerate(zip(given, own, strict=False), start=1)
        ]
    raise NoNumber(f'"parameters" is {_shown(given)}; give an object by name, or a list')


def _wrapped(given: dict[str, Any], names: Sequence[str]) -> Any:
    """Return the parameters in `{"parameters": {…}}`, `None` if `given` is no such object."""
    inside = [
        given[key]
        for key in _WRAPPERS
        if key not in names and isinstance(given.get(key), dict | list | tuple)
    ]
    return inside[0] if len(inside) == 1 and not set(given) & set(names) else None


def _by_name(given: Sequence[Any]) -> Any:
    """Return `[{"name": …, "value": …}, …]` or `[{name: value}, …]` as an object by name."""
    named: dict[str, Any] = {}
    for item in given:
        if not isinstance(item, dict):
            return given
        key = next((one for one in _NAMES if isinstance(item.get(one), str)), None)
        if key is not None:
            pairs = {item[key]: {other: item[other] for other in item if other != key}}
        elif len(item) == 1:
            pairs = item
        else:
            return given
        for name, value in pairs.items():
            if named.setdefault(name, value) != value:
                raise NoNumber(f"{_shown(name)} is given twice with different values")
    return named or given


def _unit_of(given: Mapping[str, Any]) -> Any:
    return given.get("unit", given.get("units"))


def _number(name: str, value: Any, parameter: Parameter | None, unit: Any = None) -> float:
    """Return `value` in the unit of `parameter`; `unit` is said of all parameters."""
    given = value
    if isinstance(unit, Mapping):
        unit = unit.get(name)
    elif parameter and not parameter.unit:
        unit = None  # what is said of all holds for those that have a unit
    if isinstance(value, Mapping) and "value" in value:
        unit = _unit_of(value) or unit
        value = value["value"]
    if isinstance(value, str) and (quantity := _QUANTITY.fullmatch(value.strip())):
        value, own = quantity[1], quantity[2]
        if own and isinstance(unit, str) and _plain(own) != _plain(unit):
            raise NoNumber(f"{name} is {_shown(given)}, which gives two units")
        unit = own or unit
    elif isinstance(value, bool) or not isinstance(value, int | float):
        raise NoNumber(f"{name} is {_shown(given)}; give a plain number")
    try:
        number = float(value)
    except OverflowError:
        raise NoNumber(f"{name} is no finite number") from None
    if parameter is None or not unit:
        return number
    return number / _per_own(name, given, unit, parameter.unit)


def _per_own(name: str, given: Any, unit: Any, own: str) -> float:
    """Return how many of `unit` make one of the parameter's `own`."""
    if isinstance(unit, str):
        if unit.strip().lower() == "si" or _plain(unit) == _plain(own):
            return 1.0
        for sizes in _PER_UNIT:
            if own in sizes and _plain(unit) in sizes:
                return sizes[_plain(unit)] / sizes[own]
    said = f"a number in {own}" if own else "a number without a unit"
    raise NoNumber(f"{name} is {_shown(given)} with the unit {_shown(unit)}; give {said}")


def _plain(unit: str) -> str:
    """Return a unit in the form of the table: symbols as they are, words in the singular."""
    unit = unit.strip().strip("()[]")
    return unit if len(unit) <= 3 or not unit.isalpha() else unit.lower().removesuffix("s")


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:60] + "…"
