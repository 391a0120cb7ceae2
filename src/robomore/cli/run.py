"""`robomore run`: the search, watched as it goes on."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from robomore.cli.inputs import positive, read_options
from robomore.cli.llm import ModelOptions, ReplayOptions, chosen, forecast
from robomore.cli.output import write_json


def run(
    task: str,
    /,
    *,
    preset: str = "quick",
    designer: str = "offline",
    seed: int = 0,
    workers: int | None = None,
    out: Path | None = None,
    objective: Literal["efficiency", "fitness"] | None = None,
    morphologies: int | None = None,
    rewards: int | None = None,
    screening: Literal["halving", "none"] | None = None,
    cycles: int | None = None,
    finalists: int | None = None,
    repeats: int | None = None,
    steps: int | None = None,
    final_steps: int | None = None,
    trainer: str | None = None,
    trainer_option: Annotated[list[str] | None, Parameter(negative="")] = None,
    containment: Literal["strict", "relaxed"] | None = None,
    quiet: Annotated[bool, Parameter(negative="")] = False,
    as_json: Annotated[bool, Parameter("--json", negative="")] = False,
    model: ModelOptions | None = None,
    replay: ReplayOptions | None = None,
) -> None:
    """Search for the best body and reward for a task.

    The same command again finishes a run that was interrupted.

    Parameters
    ----------
    task
        Id of a task (`robomore tasks` lists them).
    preset
        `smoke` (under a minute), `quick` (about five), `standard` or `paper`.
    designer
        Who proposes: `offline` (no LLM, the default), `llm` (with `--model`), `replay` (with
        `--from`), `human` or `random` (baselines).
    seed
        Same seed, same result, whatever the number of workers.
    workers
        Evaluations side by side; one a core by default.
    out
        The run's folder; by default below `runs/`, named after all that was asked for.
    objective
        What the search compares: `efficiency` (fitness / volume, as in the paper) or `fitness`.
    morphologies
        Rows of the coarse grid.
    rewards
        Columns of the coarse grid.
    screening
        `halving` cuts the worst pairs of the grid on the way (and tries fewer rewards on bodies
        that do badly under the reference reward); `none` trains every pair to the end, as in the
        paper.
    cycles
        Most cycles of the fine stage.
    finalists
        Designs that are retrained for the final comparison.
    repeats
        Training seeds in the final comparison.
    steps
        Control steps of training for each candidate.
    final_steps
        Control steps of each training in the final; by default in proportion to `--steps`.
    trainer
        What trains the policies, with its own defaults: `crossq` (the presets'), `sac` (the paper's
        algorithm and settings), `sb3` (the same through Stable-Baselines3; the extra `sb3`).
    trainer_option
        One setting of the trainer, as NAME=VALUE: `batch_size=512`, `hidden=[256,256]`. May be
        given several times.
    containment
        `relaxed` trains without the operating system's protection where a machine lacks it.
    quiet
        Show nothing while the run goes on.
    as_json
        Print the outcome as JSON, as `robomore show --json` does.
    """
    from robomore.report.command import overridden, settings_name
    from robomore.settings import preset as settings_of
    from robomore.tasks import get_task

    sizes: dict[str, int | None] = {
        "morphologies": morphologies,
        "rewards": rewards,
        "cycles": cycles,
        "finalists": finalists,
        "repeats": repeats,
        "steps": steps,
        "final-steps": final_steps,
    }
    positive(workers=workers, **sizes)
    options: dict[str, Any] = {name: size for name, size in sizes.items() if size is not None}
    if screening is not None:
        options["screening"] = screening
    if objective is not None:
        options["objective"] = objective
    if trainer is not None:
        options["trainer"] = trainer
    if trainer_option:
        options["trainer-option"] = read_options(trainer_option)
    settings = overridden(settings_of(preset), options)
    name = settings_name(preset, options)
    wanted = get_task(task)
    proposing = chosen(designer, model, replay)
    folder = out or Path("runs") / f"{task}-{name}-{designer}-s{seed}"

    from robomore.cli.live import watched
    from robomore.designers import LanguageModel
    from robomore.experiment import run as start

    if isinstance(proposing, LanguageModel) and not quiet:
        sys.stderr.write(forecast(wanted, proposing, settings.search) + "\n")
    with watched(quiet) as observe:
        start(
            wanted,
            settings,
            designer=proposing,
            seed=seed,
            workers=workers,
            out=folder,
            containment=containment,
            observe=observe,
            name=name,
        )

    from robomore.cli.show import print_outcome
    from robomore.report.json_export import as_data
    from robomore.report.summary import summarise

    summary = summarise(folder)
    if as_json:
        write_json(as_data(summary))
    else:
        print_outcome(summary)
