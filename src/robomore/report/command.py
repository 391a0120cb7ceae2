"""The command that starts a run again."""

from __future__ import annotations

import json
import re
import shlex

from robomore.designers.llm.designer import LLMSettings
from robomore.options import changes
from robomore.runs import Run
from robomore.store import Manifest, RunFolder

TASK_FILE = "TASK.toml"
"""What a command says for a task file: where that lay is not kept."""

_NAMELESS = re.compile(r"start \d+")
"""How a start that was given as a value in Python is called; no path leads to it."""


def from_task_file(run: Run) -> bool:
    """Return whether the task of a run came from a file, so that its id does not name it."""
    return RunFolder(run.folder).task.is_file()


def command_line(run: Run) -> str | None:
    """Return the command that gives the same run, or `None` where none can.

    That is where its settings are nobody's preset, where another run's exchanges were replayed, or
    where it started from values that were given in Python.

    Only the folder is left out: by default it is named after all that the command says. A task
    file is called `TASK_FILE`.
    """
    manifest = run.manifest
    preset = manifest.preset.split("-")[0]
    options = changes(preset, manifest.settings)
    try:
        model = _model_options(manifest)
    except (KeyError, TypeError, AttributeError):  # settings that no RoboMoRe wrote
        return None
    nameless = any(_NAMELESS.fullmatch(start.origin) for start in manifest.starts)
    if options is None or model is None or nameless:
        return None
    task = TASK_FILE if from_task_file(run) else manifest.task
    words = ["robomore", "run", task, "--preset", preset]
    words += ["--designer", manifest.designer] if manifest.designer else []
    words += [*model, "--seed", str(manifest.seed)]
    words += [] if run.budget_steps is None else ["--budget-steps", str(run.budget_steps)]
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
