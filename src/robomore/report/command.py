"""The command that starts a run again, and what single settings are called on the command line."""

from __future__ import annotations

import json
import re
import shlex
from dataclasses import replace
from typing import Any

from robomore.designers.llm.designer import LLMSettings
from robomore.settings import PRESETS, SCREENINGS, RunSettings, with_trainer
from robomore.store import Manifest

OVERRIDES = {
    "objective": ("search", "objective"),
    "morphologies": ("search", "morphologies"),
    "rewards": ("search", "rewards"),
    "screening": ("search", "screening"),
    "cycles": ("search", "max_cycles"),
    "finalists": ("search", "finalists"),
    "repeats": ("search", "repeats"),
    "steps": ("candidate", "steps"),
    "final-steps": ("final", "steps"),
}
"""Option of `robomore run` -> where it stands in the settings. Besides these there are `trainer`,
the name of an algorithm, and `trainer-option`, fields of its settings by name."""


def overridden(settings: RunSettings, options: dict[str, Any]) -> RunSettings:
    """Return `settings` with the given options (see `OVERRIDES`) in place of the preset's.

    Where `steps` is given and `final-steps` is not, the final trainings stay longer than the
    candidates' by the same factor.
    """
    if "steps" in options and "final-steps" not in options:
        factor = settings.final.steps / settings.candidate.steps
        options = {**options, "final-steps": round(options["steps"] * factor)}
    settings = with_trainer(settings, options.get("trainer"), options.get("trainer-option", {}))
    for option, value in options.items():
        if option not in OVERRIDES:
            continue
        part, name = OVERRIDES[option]
        value = SCREENINGS[value] if option == "screening" else value
        settings = replace(settings, **{part: replace(getattr(settings, part), **{name: value})})
    return settings


def settings_name(preset: str, options: dict[str, Any]) -> str:
    """Return a name for a preset with options, fit for a folder: `quick-steps5000`."""
    plain = {option: value for option, value in options.items() if option != "trainer-option"}
    plain |= options.get("trainer-option", {})
    words = [f"{option}{value}" for option, value in plain.items()]
    return "-".join([preset, *(re.sub(r"[^\w.+-]+", "_", word).strip("_") for word in words)])


def command_line(manifest: Manifest) -> str | None:
    """Return the command that gives the same run, or `None` where none can.

    That is where its settings are nobody's preset, or where another run's exchanges were replayed.

    Only the folder is left out: by default it is named after all that the command says.
    """
    preset = manifest.preset.split("-")[0]
    if preset not in PRESETS:
        return None
    options: dict[str, Any] = {}
    for option, (part, name) in OVERRIDES.items():
        wanted = getattr(getattr(manifest.settings, part), name)
        so_far = overridden(PRESETS[preset](), options)
        if getattr(getattr(so_far, part), name) != wanted:
            if option == "screening":
                wanted = next((word for word, way in SCREENINGS.items() if way == wanted), None)
                if wanted is None:
                    return None
            options[option] = wanted
    options |= _trainer_options(PRESETS[preset](), manifest.settings)
    if overridden(PRESETS[preset](), options) != manifest.settings:
        return None
    model = _model_options(manifest)
    if model is None:
        return None
    words = ["robomore", "run", manifest.task, "--preset", preset, "--designer", manifest.designer]
    words += [*model, "--seed", str(manifest.seed)]
    chosen = options.pop("trainer-option", {})
    for option, value in options.items():
        words += [f"--{option}", str(value)]
    for name, value in chosen.items():
        words += ["--trainer-option", f"{name}={json.dumps(value)}"]
    return shlex.join(words)


def _trainer_options(plain: RunSettings, wanted: RunSettings) -> dict[str, Any]:
    """Return the options that make the trainer of `wanted` of that of `plain`."""
    options: dict[str, Any] = {}
    name = wanted.trainer.name
    if name != plain.trainer.name:
        options["trainer"] = name
    usual = with_trainer(plain, name).trainer.options
    found = wanted.trainer.options.items()
    if changed := {key: value for key, value in found if key not in usual or usual[key] != value}:
        options["trainer-option"] = changed
    return options


def _model_options(manifest: Manifest) -> list[str] | None:
    """Return the options that name a language model and how it was used."""
    settings = manifest.designer_settings
    if not settings:
        return []
    if "replayed" in settings:
        return None
    history, sampling = settings["history"], settings["sampling"]
    if sampling["seed"] is not None:
        return None
    words = ["--model", settings["model"]]
    if settings["server"]:
        words = ["--base-url", settings["server"], "--model", settings["model"].partition(":")[2]]
    words += [] if settings["diversity"] else ["--no-diversity"]
    words += ["--vision"] if settings["vision"] else []
    plain = LLMSettings()
    for option, value, usual in (
        ("repairs", settings["repairs"], plain.repairs),
        ("history-tokens", history["tokens"], plain.history.tokens),
        ("history-rule", history["rule"], plain.history.rule),
        ("temperature", sampling["temperature"], None),
        ("effort", sampling["effort"], None),
        ("max-output-tokens", sampling["max_output_tokens"], None),
    ):
        if value != usual:
            words += [f"--{option}", str(value)]
    return words
