"""What a task is about: a number for each recorded episode, the larger the better.

A fitness is a named measure, a weighted sum of several, or a function of one's own. It is computed
in the trusted process, where no reward is loaded. A function of one's own is part of the task, and
so of a person's own file or package; no designer can name one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from robomore.errors import FitnessFailed, InputError
from robomore.suggestions import did_you_mean
from robomore.tasks.measures import MEASURES, FitnessMeasure
from robomore.tasks.trajectory import Trajectory

OWN = "own"
"""Name of a measure that is a function of the task's author."""


@dataclass(frozen=True, slots=True)
class Term:
    """A measure with its options and its weight in a sum.

    Attributes:
        name: of the measure.
        options: of the measure by name.
        weight: what the measure is multiplied by; below 0 for what should be small.
        own: the measure itself, if it is not a registered one.
    """

    name: str
    options: Mapping[str, Any] = field(default_factory=dict)
    weight: float = 1.0
    own: FitnessMeasure | None = None

    def __post_init__(self) -> None:
        """Refuse an unknown measure, and options that are unknown, missing or cannot be meant.

        Raises:
            InputError: naming the remedy.
        """
        known = self.measure.options
        if unknown := sorted(set(self.options) - set(known)):
            raise InputError(
                f"the fitness {self.name!r} has no option {', '.join(map(repr, unknown))}."
                f"{did_you_mean(unknown[0], known)} It takes {', '.join(known) or 'none'}"
            )
        values = {**known, **self.options}
        if missing := [name for name, value in values.items() if value is None]:
            raise InputError(
                f"the fitness {self.name!r} needs {' and '.join(missing)}: "
                f"Fitness.of({self.name!r}, {', '.join(f'{name}=…' for name in missing)})"
            )
        for option, check in self.measure.checks.items():
            if wanted := check(values[option]):
                raise InputError(
                    f"the fitness {self.name!r} has {option} = {values[option]!r}; give {wanted}"
                )
        if not math.isfinite(self.weight) or self.weight == 0:
            raise InputError(f"the weight of {self.name!r} is {self.weight}; give another number")
        object.__setattr__(self, "options", values)

    @property
    def measure(self) -> FitnessMeasure:
        return self.own or MEASURES.get(self.name)


@dataclass(frozen=True, slots=True)
class Fitness:
    """A sum of terms, one of them in most cases.

    `Fitness.of("speed-kept", speed=1.5)` is one measure, `Fitness.sum((1.0, "distance"),
    (-0.002, "energy"))` a weighted sum, and `Fitness.own(function, unit="m", meaning="…")` a
    function of one's own.

    Attributes:
        terms: what is added up.
        unit: SI unit; empty for a number without one.
    """

    terms: tuple[Term, ...]
    unit: str

    @classmethod
    def of(cls, name: str, /, **options: Any) -> Fitness:
        """Return one named measure as a fitness.

        Raises:
            InputError: there is no such measure, an option is wrong, or less of it is better.
        """
        term = Term(name, options)
        return cls((term,), term.measure.unit)

    @classmethod
    def sum(cls, *weighted: tuple[float, str | Fitness], unit: str | None = None) -> Fitness:
        """Return a weighted sum of measures.

        Args:
            weighted: a weight, and a measure by its name or as a `Fitness`.
            unit: of the sum; by default that of the measures, if they have the same one.

        Raises:
            InputError: a name or a weight is wrong.
        """
        terms = tuple(
            Term(term.name, term.options, weight * term.weight, term.own)
            for weight, part in weighted
            for term in as_terms(part)
        )
        units = {term.measure.unit for term in terms}
        common = units.pop() if len(units) == 1 else ""
        return cls(terms, common if unit is None else unit)

    @classmethod
    def own(cls, function: Callable[[Trajectory], float], *, unit: str, meaning: str) -> Fitness:
        """Return a function of one's own as a fitness; larger is better.

        Args:
            function: returns a finite number for a `Trajectory`. It runs where policies are
                measured, so that no reward can reach it.
            unit: of its result; empty for a number without one.
            meaning: one phrase for designers and people: "how far …".
        """
        measure = FitnessMeasure(meaning, unit, function, motion="other")
        return cls((Term(OWN, own=measure),), unit)

    def __post_init__(self) -> None:
        """Refuse a fitness without terms, or one that a search would make as bad as it can.

        Raises:
            InputError: naming the remedy.
        """
        if not self.terms:
            raise InputError("a fitness needs at least one measure")
        for term in self.terms:
            if term.weight > 0 and not term.measure.higher_is_better:
                raise InputError(
                    f"less {term.name} is better, and a search makes fitness as large as it can; "
                    f"take {term.measure.instead or 'another measure'}, or give {term.name} a "
                    f'negative weight: Fitness.sum((1.0, "distance"), (-0.002, "{term.name}"))'
                )

    @property
    def name(self) -> str:
        """Name of the measure, or all of them with their weights."""
        if len(self.terms) == 1 and self.terms[0].weight == 1:
            return self.terms[0].name
        signed = [f"{term.weight:+g} {term.name}" for term in self.terms]
        return " ".join(signed).removeprefix("+")

    @property
    def meaning(self) -> str:
        """What is measured, in words for designers, without its unit."""
        said = [_in_words(term) for term in self.terms]
        if len(said) == 1 and self.terms[0].weight == 1:
            return said[0]
        parts = [
            f"{term.weight:g} times {words}{_in_unit(term.measure.unit)}"
            for term, words in zip(self.terms, said, strict=True)
        ]
        return "the sum of these: " + "; ".join(parts)

    @property
    def per_volume(self) -> str:
        """Unit of efficiency."""
        return per_volume(self.unit)

    @property
    def may_be_negative(self) -> bool:
        """Whether something is subtracted, so that dividing by a volume would reward material."""
        return any(term.weight < 0 for term in self.terms)

    @property
    def motion(self) -> str:
        """Where the first term leads: `forward`, `upward` or `other`."""
        return self.terms[0].measure.motion

    def __call__(self, trajectory: Trajectory) -> float:
        """Return what an episode is worth.

        Raises:
            FitnessFailed: a measure raised, or it or the sum is no finite number.
        """
        value = sum(term.weight * _value(term, trajectory) for term in self.terms)
        if not math.isfinite(value):
            raise FitnessFailed(f"the fitness {self.name!r} gave {value}; use smaller weights")
        return value


def per_volume(unit: str) -> str:
    """Return the unit of efficiency, which is a fitness in `unit` over a volume in m³."""
    return f"{unit or '1'}/m³"


def as_fitness(given: object) -> Fitness:
    """Return a fitness for what a task says: a `Fitness`, or the name of a measure.

    Raises:
        InputError: it is neither.
    """
    if isinstance(given, Fitness):
        return given
    if isinstance(given, str):
        return Fitness.of(given)
    if callable(given):
        raise InputError(
            "the fitness is a function; say what it measures: Fitness.own(function, unit='m', "
            "meaning='how far …')"
        )
    raise InputError(
        f"the fitness is {given!r}; give the name of a measure ({', '.join(MEASURES.names())}) or "
        "a Fitness"
    )


def as_terms(part: str | Fitness) -> tuple[Term, ...]:
    """Return the terms of a fitness; a name alone may be one where less is better."""
    return (Term(part),) if isinstance(part, str) else part.terms


def _value(term: Term, trajectory: Trajectory) -> float:
    try:
        value = float(term.measure.function(trajectory, **term.options))
    except Exception as error:
        said = f"{type(error).__name__}: {error}"
        raise FitnessFailed(f"the fitness {term.name!r} of the task raised {said}") from error
    if not math.isfinite(value):
        raise FitnessFailed(f"the fitness {term.name!r} of the task gave {value}, no finite number")
    return value


def _in_words(term: Term) -> str:
    shown = {name: _shown(value) for name, value in term.options.items()}
    return term.measure.meaning.format(**shown) if term.own is None else term.measure.meaning


def _shown(value: Any) -> str:
    if isinstance(value, list | tuple):
        return "(" + ", ".join(map(_shown, value)) + ")"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _in_unit(unit: str) -> str:
    return f" (in {unit})" if unit else ""
