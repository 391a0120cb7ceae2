"""Everything that a run can be told, as typed values; presets are functions that return them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields, is_dataclass, replace
from types import NoneType
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin, get_type_hints

import msgspec

from robomore.errors import InputError
from robomore.suggestions import did_you_mean, no_such
from robomore.types import MethodSettings, TrainerSettings

T = TypeVar("T")

Objective = Literal["efficiency", "fitness", "transport-economy"]


@dataclass(frozen=True, slots=True)
class Budget:
    """How much training and measuring one evaluation gets."""

    steps: int
    """Control steps of training, over all environments together."""
    episodes: int = 10
    """Episodes of the measurement, each with its own seed."""


@dataclass(frozen=True, slots=True)
class FinalSettings(Budget):
    """The last comparison, which is the same for every method (`robomore.search.final`)."""

    finalists: int = 1
    """How many of the best designs are trained anew; the paper takes one."""
    seeds: int = 5
    """Training seeds of each design in the final. The paper says four; fewer than five seeds give
    no interval."""
    require_audit: bool = False
    """Whether a design has to pass its audit (`robomore.audit`) before it can be champion."""


@dataclass(frozen=True, slots=True)
class RunSettings:
    """All that decides a run's numbers, but for task, designer and seed."""

    method: MethodSettings
    """Which search decides what is tried, and its options."""
    trainer: TrainerSettings
    """Which algorithm trains the policies, and its options."""
    candidate: Budget
    """What every candidate of the search gets."""
    final: FinalSettings
    """What the finalists and the reference design get, once for each training seed."""
    evaluations: int
    """About how many full trainings a search may use. Methods that are not told a size take it."""
    objective: Objective = "efficiency"
    """What is compared. The paper optimises efficiency."""
    max_volume: float | None = None
    """Largest volume of a design, in m³; a larger one is refused before training."""
    max_density: float | None = None
    """Largest mass divided by volume, in kg/m³; a denser design is refused before training."""


ROBOMORE = "robomore"
"""The method of the paper, which is the presets' own."""

OURS = {"slim_reference": "in", "order": "adaptive"}
"""What `quick` and `standard` add to the paper's method (`docs/differences.md`)."""


def smoke() -> RunSettings:
    """Checks in about a minute that everything works; nothing learns much."""
    sizes = {"morphologies": 2, "rewards": 2, "survivors": 0.25, "max_cycles": 1}
    return RunSettings(
        method=MethodSettings(ROBOMORE, sizes),
        trainer=TrainerSettings("crossq", {"learning_starts": 512, "num_eval_checkpoints": 1}),
        candidate=Budget(steps=2_048, episodes=2),
        final=FinalSettings(steps=2_048, episodes=2, seeds=1),
        evaluations=4,
    )


def quick() -> RunSettings:
    """Some minutes on two cores, with a result worth looking at."""
    sizes = {"morphologies": 4, "rewards": 3, "survivors": 0.1, "max_cycles": 2} | OURS
    return RunSettings(
        method=MethodSettings(ROBOMORE, sizes),
        trainer=TrainerSettings("crossq"),
        candidate=Budget(steps=30_000, episodes=5),
        final=FinalSettings(steps=30_000, episodes=10),
        evaluations=16,
    )


def standard() -> RunSettings:
    """The paper's 25 x 5 grid, screened, with a trainer that needs about a minute of one core."""
    return RunSettings(
        method=MethodSettings(ROBOMORE, {"screening": "halving"} | OURS),
        trainer=TrainerSettings("crossq"),
        candidate=Budget(steps=150_000, episodes=10),
        final=FinalSettings(steps=300_000, episodes=20, finalists=2),
        evaluations=72,
    )


def paper() -> RunSettings:
    """The paper's budget: 5e5 steps a candidate, 1e6 for the winner, 100 episodes."""
    return RunSettings(
        method=MethodSettings(ROBOMORE, {"reference_reward": "out"}),
        trainer=TrainerSettings("crossq"),
        candidate=Budget(steps=500_000, episodes=100),
        final=FinalSettings(steps=1_000_000, episodes=100),
        evaluations=160,
    )


PRESETS: dict[str, Callable[[], RunSettings]] = {
    "smoke": smoke,
    "quick": quick,
    "standard": standard,
    "paper": paper,
}


def preset(name: str) -> RunSettings:
    """Return the settings of a preset.

    Raises:
        InputError: there is no preset of that name.
    """
    if name not in PRESETS:
        raise no_such("preset", name, PRESETS)
    return PRESETS[name]()


def with_trainer(
    settings: RunSettings, name: str | None = None, options: Mapping[str, Any] = {}
) -> RunSettings:
    """Return `settings` with another trainer, or with other options for the one they have.

    Options belong to an algorithm: another one starts from its own defaults, and what `settings`
    say of the old one is dropped.

    Args:
        settings: a preset, for example.
        name: of an algorithm (`robomore.training.settings`); `None` for that of `settings`.
        options: fields of the algorithm's settings by name.
    """
    trainer = settings.trainer
    if name is not None and name != trainer.name:
        trainer = TrainerSettings(name)
    trainer = replace(trainer, options={**trainer.options, **options})
    return replace(settings, trainer=trainer)


def with_method(
    settings: RunSettings, name: str | None = None, options: Mapping[str, Any] = {}
) -> RunSettings:
    """Return `settings` with another search method, or with other options for theirs.

    Args:
        settings: a preset, for example.
        name: of a method (`robomore methods` lists them); `None` for that of `settings`.
        options: fields of the method's settings by name.
    """
    method = settings.method
    if name is not None and name != method.name:
        method = MethodSettings(name)
    method = replace(method, options={**method.options, **options})
    return replace(settings, method=method)


def with_steps(settings: RunSettings, steps: int) -> RunSettings:
    """Return `settings` with other steps a candidate; the final's change by the same factor."""
    factor = steps / settings.candidate.steps
    return replace(
        settings,
        candidate=replace(settings.candidate, steps=steps),
        final=replace(settings.final, steps=round(settings.final.steps * factor)),
    )


def from_options(cls: type[T], options: Mapping[str, Any], owner: str) -> T:
    """Return a settings class filled with options by name; the rest keeps its defaults.

    Args:
        cls: a frozen dataclass whose fields all have defaults, with msgspec constraints.
        options: values by field name, as JSON gives them.
        owner: whose options they are, for messages: `method robomore`.

    Raises:
        InputError: naming an unknown option, or a value of the wrong kind or out of range.
    """
    known = [field.name for field in fields(cls)]  # type: ignore[arg-type]
    if unknown := sorted(set(options) - set(known)):
        raise InputError(
            f"{owner} has no option {', '.join(map(repr, unknown))}."
            f"{did_you_mean(unknown[0], known)} It takes {', '.join(known) or 'none'}"
        )
    for name, value in options.items():
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"{owner}: {name} = {value} is not a finite number")
    try:
        return msgspec.convert({**asdict(cls()), **options}, cls)  # type: ignore[call-overload]
    except msgspec.ValidationError as error:
        hints = get_type_hints(cls, include_extras=True)
        for name, value in options.items():
            _ensure_takes(hints[name], value, f"{owner}: {name}")
        raise InputError(f"{owner}: {error}") from None


def _ensure_takes(hint: Any, value: Any, name: str) -> None:
    try:
        msgspec.convert(value, hint)
    except msgspec.ValidationError as error:
        given = msgspec.json.encode(value).decode()
        where = f" ({error})" if isinstance(value, list | dict) else ""
        raise InputError(f"{name} is {given}; it takes: {in_words(hint)}{where}") from None


def in_words(hint: Any) -> str:
    """Return what values the type of an option takes, such as `whole number, at least 1`."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Annotated:
        base, *metas = parts
        limits = [
            f"{word} {value:g}"
            for meta in metas
            if isinstance(meta, msgspec.Meta)
            for word, value in (
                ("at least", meta.ge),
                ("above", meta.gt),
                ("at most", meta.le),
                ("below", meta.lt),
            )
            if value is not None
        ]
        return ", ".join([in_words(base), *limits])
    if origin is Literal:
        return " or ".join(str(value) for value in parts)
    if origin is tuple and parts[-1] is Ellipsis:
        return f"list, each {in_words(parts[0])}"
    if parts:
        return "; or ".join(in_words(part) for part in parts)
    if is_dataclass(hint):
        return "{" + ", ".join(field.name for field in fields(hint)) + "}"
    names = {int: "whole number", float: "number", str: "text", bool: "true or false"}
    return "null" if hint in (NoneType, None) else names.get(hint, str(hint))
