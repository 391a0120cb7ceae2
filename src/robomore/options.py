"""What may be changed in a preset, one name for each: as arguments, in words, and found again."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, get_args

from robomore.errors import InputError
from robomore.identity import content_key
from robomore.settings import (
    PRESETS,
    Objective,
    RunSettings,
    preset,
    with_method,
    with_steps,
    with_trainer,
)
from robomore.suggestions import did_you_mean
from robomore.text import one_line

_LONGEST_NAME = 100
"""Characters of a name of settings; file systems take 255 for all of a folder's name."""
_LONGEST_WORD = 24
"""Characters of a value that is said."""


def with_options(
    settings: RunSettings,
    *,
    method: str | None = None,
    method_options: Mapping[str, Any] = {},
    trainer: str | None = None,
    trainer_options: Mapping[str, Any] = {},
    steps: int | None = None,
    final_steps: int | None = None,
    finalists: int | None = None,
    final_seeds: int | None = None,
    require_audit: bool | None = None,
    evaluations: int | None = None,
    objective: Objective | None = None,
    max_volume: float | None = None,
    max_density: float | None = None,
) -> RunSettings:
    """Return `settings` with some of them changed; `None` leaves one as it is.

    Whether a method or a trainer of that name exists, and takes these options, is checked where it
    is made (`robomore.search.make_method`, `robomore.training.settings.ensure_trainer`).

    Args:
        settings: a preset, for example.
        method: name of a search method; another one starts from its own defaults.
        method_options: fields of the method's settings by name.
        trainer: name of a trainer; another one starts from its own defaults.
        trainer_options: fields of the trainer's settings by name.
        steps: control steps of training for each candidate; the final's change by the same factor.
        final_steps: control steps of each training in the final.
        finalists: designs of the search that are trained anew in the final.
        final_seeds: training seeds of each design in the final.
        require_audit: whether a design has to pass its audit before it can be champion.
        evaluations: about how many full trainings a search may use, for methods that are not told
            a size of their own.
        objective: what is compared: `efficiency`, `fitness` or `transport-economy`.
        max_volume: largest volume of a design, in m³.
        max_density: largest mass divided by volume, in kg/m³.

    Raises:
        InputError: a number out of range, or an unknown objective.
    """
    for option, value in (
        ("steps", steps),
        ("final-steps", final_steps),
        ("finalists", finalists),
        ("final-seeds", final_seeds),
        ("evaluations", evaluations),
    ):
        if value is not None and value < 1:
            raise InputError(f"--{option} is {value}; give a number from 1 up")
    for option, limit, unit in (
        ("max-volume", max_volume, "m³"),
        ("max-density", max_density, "kg/m³"),
    ):
        if limit is not None and not 0 < limit < math.inf:
            raise InputError(f"--{option} is {limit:g}; give a positive number in {unit}")
    if objective is not None and objective not in get_args(Objective):
        raise InputError(
            f"--objective is {objective!r}.{did_you_mean(objective, get_args(Objective))} Choose "
            f"one of {', '.join(get_args(Objective))}"
        )
    settings = with_method(settings, method, method_options)
    settings = with_trainer(settings, trainer, trainer_options)
    if steps is not None:
        settings = with_steps(settings, steps)
    final: dict[str, Any] = {
        "steps": final_steps,
        "finalists": finalists,
        "seeds": final_seeds,
        "require_audit": require_audit,
    }
    given = {name: value for name, value in final.items() if value is not None}
    settings = replace(settings, final=replace(settings.final, **given))
    whole: dict[str, Any] = {
        "evaluations": evaluations,
        "objective": objective,
        "max_volume": max_volume,
        "max_density": max_density,
    }
    return replace(settings, **{name: value for name, value in whole.items() if value is not None})


def changes(name: str, settings: RunSettings) -> dict[str, Any] | None:
    """Return the arguments of `with_options` that make `settings` of a preset.

    Args:
        name: of the preset.
        settings: that are wanted.

    Returns:
        Only what differs; `None` where there is no such preset, or no options give these settings.
    """
    if name not in PRESETS:
        return None
    plain = preset(name)
    found: dict[str, Any] = {}
    for kind, change in (("method", with_method), ("trainer", with_trainer)):
        wanted = getattr(settings, kind)
        if wanted.name != getattr(plain, kind).name:
            found[kind] = wanted.name
        usual = getattr(change(plain, wanted.name), kind).options
        if differing := {
            option: value
            for option, value in wanted.options.items()
            if option not in usual or usual[option] != value
        }:
            found[f"{kind}_options"] = differing
    if settings.candidate.steps != plain.candidate.steps:
        found["steps"] = settings.candidate.steps
        plain = with_steps(plain, settings.candidate.steps)
    for option, field in (
        ("final_steps", "steps"),
        ("finalists", "finalists"),
        ("final_seeds", "seeds"),
        ("require_audit", "require_audit"),
    ):
        if getattr(settings.final, field) != getattr(plain.final, field):
            found[option] = getattr(settings.final, field)
    for option in ("evaluations", "objective", "max_volume", "max_density"):
        if getattr(settings, option) != getattr(plain, option):
            found[option] = getattr(settings, option)
    return found if with_options(preset(name), **found) == settings else None


def settings_words(name: str, settings: RunSettings, budget_steps: int | None = None) -> str:
    """Return how settings are called before people: `preset quick, with rewards 2, steps 5,000`.

    The search method is left out, which is always said besides.

    Args:
        name: of the settings, as `settings_name` returned it.
        settings: that have this name.
        budget_steps: that the search might use; `None` for no bound.
    """
    budget = [] if budget_steps is None else [_said("budget_steps", budget_steps)]
    plain, changed, _ = name.partition("-")
    if plain not in PRESETS:
        said = f"{plain} settings" if plain == "custom" else f"settings {name}"
        return ", ".join([said, *budget])
    try:
        found = changes(plain, settings) if changed else {}
    except InputError:  # a method or trainer that is not installed here
        found = None
    if found is None:
        return ", ".join([f"settings {name}", *budget])
    words = []
    for option, value in found.items():
        if isinstance(value, Mapping):
            words += [_said(one, chosen) for one, chosen in value.items()]
        elif option != "method":
            words.append(_said(option, value))
    words += budget
    return one_line(f"preset {plain}, with {', '.join(words)}") if words else f"preset {plain}"


def _said(option: str, value: object) -> str:
    """Return an option with its value in words; a long text or a list is only said to be given."""
    said = option.replace("_", " ")
    if isinstance(value, bool):
        return said if value else f"without {said}"
    if isinstance(value, int):
        return f"{said} {value:,}"
    if isinstance(value, float):
        return f"{said} {value:g}"
    if isinstance(value, str) and len(value) <= _LONGEST_WORD and value.isprintable():
        return f"{said} {value}"
    return f"{said} none" if value is None else f"{said} of its own"


def settings_name(name: str, settings: RunSettings) -> str:
    """Return a name for settings made of a preset, fit for a folder: `quick-steps5000`.

    Args:
        name: of the preset. It stands before the first `-`.
        settings: made of the preset. Where no options give them, they are called `custom`.
    """
    found = changes(name, settings)
    if found is None:
        return "custom"
    words = [name]
    for option, value in found.items():
        if isinstance(value, str):
            words.append(value)
        elif value is True:
            words.append(option.replace("_", "-"))
        elif isinstance(value, Mapping):
            words += [f"{one}{_plain(chosen)}" for one, chosen in value.items()]
        else:
            words.append(f"{option.replace('_', '-')}{value}")
    said = "-".join(re.sub(r"[^\w.+-]+", "_", word).strip("_") for word in words)
    if len(said) > _LONGEST_NAME:
        said = f"{said[: _LONGEST_NAME - 9]}-{content_key(found)[:8]}"
    return said


def _plain(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value)
