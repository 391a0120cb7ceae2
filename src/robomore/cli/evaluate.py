"""`robomore evaluate`: one design, trained and measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated, Literal

import msgspec
from cyclopts import Parameter

from robomore.cli.completion import PRESET, TASK
from robomore.cli.inputs import (
    new_folder,
    positive,
    read_options,
    read_parameters,
    read_reward,
    seed_number,
)
from robomore.cli.output import console, write, write_json
from robomore.cli.whole import Whole

if TYPE_CHECKING:
    from robomore.tasks.fitness import Fitness
    from robomore.types import Evaluation


def evaluate(
    task: Annotated[str, TASK],
    /,
    *,
    parameters: str = "reference",
    reward: str = "reference",
    preset: Annotated[str, PRESET] = "quick",
    steps: Whole | None = None,
    trainer: str | None = None,
    trainer_option: Annotated[list[str] | None, Parameter(negative="")] = None,
    seed: Whole = 0,
    out: Path | None = None,
    containment: Literal["strict", "relaxed"] | None = None,
    as_json: Annotated[bool, Parameter("--json", negative="")] = False,
) -> int:
    """Train and measure one design. Exits with status 1 if it could not be trained.

    Parameters
    ----------
    task
        Id of a task (`robomore tasks` lists them), or the path of a task file (.toml).
    parameters
        `reference`, or a JSON file: a list in the task's order, or an object by name.
    reward
        `reference`, or a Python file that defines `_get_rew(self, x_velocity, action)`.
    preset
        Preset whose trainer and budget are used: `smoke`, `quick`, `standard` or `paper`.
    steps
        Control steps of training, instead of the preset's.
    trainer
        The algorithm, with its own defaults: `crossq` (that of the presets), `sac` (the paper's
        algorithm and settings) or `sb3` (the same through Stable-Baselines3; needs the extra
        `sb3`).
    trainer_option
        One option of the trainer, as NAME=VALUE: `batch_size=512`, `net_arch=[256,256]`. May be
        given several times.
    seed
        Seed of training and measuring.
    out
        Keep design and policy in this folder, for `robomore play`.
    containment
        `strict` refuses to start if this machine does not offer all sandbox layers for rewards,
        `relaxed` runs with the layers that are available.
    as_json
        Print the evaluation as JSON.
    """
    from robomore.settings import preset as settings_of
    from robomore.settings import with_trainer
    from robomore.tasks import get_task

    positive(steps=steps)
    seed_number(seed)
    options = read_options("trainer-option", trainer_option, "batch_size=512")
    settings = with_trainer(settings_of(preset), trainer, options)
    chosen = get_task(task)
    values = read_parameters(chosen, parameters)
    source = read_reward(chosen, reward)
    if out is not None:
        new_folder(out)

    from robomore.experiment import evaluate as measure

    with _progress(steps or settings.candidate.steps) as progress:
        evaluation = measure(
            chosen,
            values,
            source,
            settings,
            steps=steps,
            seed=seed,
            artifact=out,
            containment=containment,
            progress=progress,
        )
    if out is not None and evaluation.ok:
        from robomore.store.champion import write_design, write_sums

        write_design(out, chosen, [evaluation])
        write_sums(out)
    if as_json:
        data = msgspec.to_builtins(evaluation)
        # The job is long: whoever reads it with their eyes wants the outcome first.
        write_json({**{k: v for k, v in data.items() if k != "job"}, "job": data["job"]})
    else:
        _print(evaluation, chosen.goal)
        if out is not None and evaluation.ok:
            write(f"written     {out} (watch: robomore play {quote(str(out))})\n")
    return 0 if evaluation.ok else 1


@contextmanager
def _progress(steps: int) -> Iterator[Callable[[int], None]]:
    """Show how far training is, in a terminal alone."""
    screen = console(stderr=True)
    if not screen.is_terminal:
        yield lambda done: None
        return
    from rich.progress import Progress

    with Progress(console=screen, transient=True) as bars:
        bar = bars.add_task("training", total=steps)
        yield lambda done: bars.update(bar, completed=done)


def _print(evaluation: Evaluation, goal: Fitness) -> None:
    from robomore.runs.words import duration, label, measured, number

    lines = [f"status      {evaluation.status}"]
    if evaluation.ok:
        episodes = evaluation.episode_fitness
        low, high = number(min(episodes)), number(max(episodes))
        spread = f"mean of {len(episodes)} episodes, {low} to {high}"
        lines += [
            f"efficiency  {number(evaluation.efficiency)} {goal.per_volume}",
            f"fitness     {number(evaluation.fitness)} {goal.unit}".rstrip() + f" ({spread})",
            f"volume      {number(evaluation.volume)} m³",
        ]
        lines += [
            f"{label(name)}: {measured(name, value)}"
            for name, value in evaluation.behaviour.items()
        ]
        lines += [
            f"term {name}: mean {number(term.mean)}, from {number(term.low)} to {number(term.high)}"
            for name, term in evaluation.terms.items()
        ]
    else:
        lines.append(f"diagnosis   {evaluation.diagnosis}")
    lines.append(
        f"cost        {evaluation.steps:,} steps, {duration(evaluation.seconds)} of a core"
    )
    lines += [f"note        {note}" for note in evaluation.notes]
    write("\n".join(lines) + "\n")
