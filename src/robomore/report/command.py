"""The command that starts a run again."""

from __future__ import annotations

import json
import shlex

from robomore.designers.llm.designer import LLMSettings
from robomore.options import changes
from robomore.store import Manifest


def command_line(manifest: Manifest) -> str | None:
    """Return the command that gives the same run, or `None` where none can.

    That is where its settings are nobody's preset, or where another run's exchanges were replayed.

    Only the folder is left out: by default it is named after all that the command says.
    """
    preset = manifest.preset.split("-")[0]
    options = changes(preset, manifest.settings)
    try:
        model = _model_options(manifest)
    except (KeyError, TypeError, AttributeError):  # settings that no RoboMoRe wrote
        return None
    if options is None or model is None:
        return None
    words = ["robomore", "run", manifest.task, "--preset", preset]
    words += ["--designer", manifest.designer] if manifest.designer else []
    words += [*model, "--seed", str(manifest.seed)]
    for start in manifest.starts:
        words += ["--start-from", start.origin]
    for option, value in options.items():
        if isinstance(value, dict):
            flag = f"--{option.removesuffix('s').replace('_', '-')}"
            for name, chosen in value.items():
                words += [flag, f"{name}={_plain(chosen)}"]
        elif value is True:
            words.append(f"--{option.replace('_', '-')}")
        else:
            words += [f"--{option.replace('_', '-')}", str(value)]
    return shlex.join(words)


def _plain(value: object) -> str:
    """Return a value as the command line reads it: JSON, or text that is no JSON."""
    if isinstance(value, str):
        try:
            json.loads(value)
        except ValueError:
            return value
    return json.dumps(value)


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
        name = settings["model"].removeprefix("compatible:")  # as older runs wrote it
        words = ["--base-url", settings["server"], "--model", name]
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
