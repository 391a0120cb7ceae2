"""The model card: what was exported, how good it is, how that is known, and what it is not."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import mujoco

from robomore.errors import InputError
from robomore.export.environment import environment_id, package_name, stands_alone
from robomore.export.printing import Piece, Printer, fitting_scale, in_mm
from robomore.export.urdf import lost_in_urdf
from robomore.report.command import TASK_FILE, command_line, from_task_file
from robomore.runs import Run
from robomore.runs.words import in_unit, label, measured, number, with_interval
from robomore.text import one_line, text_only
from robomore.training.settings import settings_from
from robomore.types import Evaluation, Job


def model_card(
    run: Run,
    evaluation: Evaluation,
    name: str,
    model: mujoco.MjModel,
    pieces: Sequence[Piece],
    printer: Printer,
    again: Sequence[float],
    video: str,
) -> str:
    """Return the card as Markdown.

    Args:
        run: that trained the policy.
        evaluation: of the exported policy.
        name: of the design.
        model: of the robot.
        pieces: of the robot as solids.
        printer: that they were checked for.
        again: fitness of the first episodes, run by the exported code alone.
        video: name of its file; empty without one.
    """
    sections = (
        _head(run, evaluation, name),
        _numbers(run, evaluation, again),
        _training(run, evaluation, model),
        _use(run, name, video),
        _robot(model),
        _print(pieces, printer),
        _limits(run),
    )
    return "\n".join(line for section in sections for line in section)


def _head(run: Run, evaluation: Evaluation, name: str) -> list[str]:
    design = evaluation.design
    return [
        f"# {text_only(run.task.title)}, {text_only(name)}",
        "",
        "A simulated robot, the reward that it was trained with, and its trained policy, exported",
        f"by RoboMoRe {text_only(run.manifest.versions.get('robomore', ''))}.",
        "",
        f"- Task: {text_only(run.task.id)}. {text_only(run.task.description)}",
        f"- Idea of the morphology: {text_only(design.morphology.idea) or 'not given'}",
        f"- Idea of the reward: {text_only(design.reward.idea) or 'not given'}",
        f"- Who made the proposals: {text_only(run.manifest.provenance)}",
        "",
    ]


def _numbers(run: Run, evaluation: Evaluation, again: Sequence[float]) -> list[str]:
    champion = run.champion
    assert champion is not None
    episodes, unit = evaluation.episode_fitness, run.fitness_unit
    whose = f"the evaluation `{evaluation.key}`" if run.focus else "the best training seed"
    lines = [
        "## Numbers",
        "",
        f"Of the exported policy, which is that of {whose}:",
        "",
        "| measure | value |",
        "|---|---|",
        f"| fitness ({run.task.goal.name}), mean of {len(episodes)} episodes | "
        f"{in_unit(evaluation.fitness, 'fitness', unit)} |",
        f"| lowest and highest episode | {number(min(episodes))}, {number(max(episodes))} |",
        f"| volume | {number(evaluation.volume)} m³ |",
        f"| efficiency (fitness / volume) | {in_unit(evaluation.efficiency, 'efficiency', unit)} |",
    ]
    for key in ("mass", "density", "rest_height"):
        if key in evaluation.body:
            lines.append(f"| {label(key)} | {number(evaluation.body[key])} |")
    for key in ("forward_speed_m_s", "energy_j", "fell_share"):
        if key in evaluation.behaviour:
            lines.append(f"| {label(key)} | {measured(key, evaluation.behaviour[key])} |")
    lines.append("")
    if champion.fitness and len(champion.evaluations) > 1:
        said = with_interval(champion.fitness, unit)
        lines += [f"Over all training seeds of this design, the fitness is {said}.", ""]
    of_unit = f" {unit}" if unit else ""
    here, before = sum(again) / len(again), sum(episodes[: len(again)]) / len(again)
    return [
        *lines,
        f"When this folder was made, its own code ran {len(again)} of these episodes and reached",
        f"{number(here, 6)}{of_unit}; {number(before, 6)}{of_unit} stands in the record of them.",
        "",
    ]


def _training(run: Run, evaluation: Evaluation, model: mujoco.MjModel) -> list[str]:
    job, versions = evaluation.job, run.manifest.versions
    used = ", ".join(f"{text_only(name)} {text_only(found)}" for name, found in versions.items())
    lines = [
        "## Training",
        "",
        f"- Trainer: {text_only(job.trainer.name)}, {job.steps:,} control steps, seed {job.seed}",
        *_integrated(job, model),
        f"- Evaluation: `{evaluation.key}` of the run `{text_only(run.folder.name)}`, "
        f"method {text_only(run.manifest.settings.method.name)}",
        f"- Versions: {used}",
    ]
    command = command_line(run)
    if command:
        lines += ["", "The run is repeated by", "", f"    {one_line(command)}"]
    if command and from_task_file(run):
        lines += ["", f"where `{TASK_FILE}` stands for the task file that it was given."]
    return [*lines, ""]


def _integrated(job: Job, model: mujoco.MjModel) -> list[str]:
    """Return how the robot was integrated in training, if that is not how it is measured."""
    if model.opt.integrator != mujoco.mjtIntegrator.mjINT_RK4:
        return []
    with suppress(InputError):  # a trainer that is not installed here
        if getattr(settings_from(job.trainer), "replace_rk4", False):
            return [
                "- Integrator in training: implicitfast at half the timestep; in measuring that of "
                "`robot/robot.xml`"
            ]
    return []


def _use(run: Run, name: str, video: str) -> list[str]:
    package, id = package_name(run.task, name), environment_id(run.task, name)
    needs = "It needs no RoboMoRe." if stands_alone(run.task) else "It needs RoboMoRe and the task."
    return [
        "## Use",
        "",
        "| file | what it is |",
        "|---|---|",
        "| `robot/robot.xml` | MJCF: robot and ground as measured; MuJoCo loads it alone |",
        "| `robot/robot.urdf` | the same robot without ground for other simulators |",
        "| `policy/policy.onnx` | policy: input `observation` (n, numbers), output `action` |",
        "| `policy/policy.py` | the same policy; it imports NumPy alone |",
        f"| `environment/` | Python package `{package}`: Gymnasium environment, reward, policy |",
        "| `print/` | the robot's pieces as STL and 3MF, in mm |",
        *([f"| `{video}` | the policy in one episode |"] if video else []),
        "",
        "    pip install ./environment",
        f"    python -m {package}      # runs the episodes of the table, without the reward",
        "",
        f"`gymnasium.make({id!r})` gives the environment after `import {package}`. {needs}",
        "`reward.py` in it is a program by whoever proposed it, and runs when the environment is",
        "made: read it before you use it. Observations go into the policy as they come, and its",
        "actions lie in [-1, 1].",
        "",
    ]


def _robot(model: mujoco.MjModel) -> list[str]:
    lost = "; ".join(lost_in_urdf(model))
    return [
        "## What the URDF leaves out",
        "",
        f"URDF cannot say: {lost}.",
        "",
        "Each capsule is a cylinder and two balls. Where the model has no limit and URDF requires",
        "one, 1000000 stands. So the policy acts well in the MJCF model, and not necessarily in a",
        "simulator that reads the URDF.",
        "",
    ]


def _print(pieces: Sequence[Piece], printer: Printer) -> list[str]:
    largest = fitting_scale(list(pieces), printer)
    lines = [
        "## 3D printing",
        "",
        f"Scale {printer.scale:g}, checked for a bed of {in_mm(printer.bed)}, walls of "
        f"{printer.wall:g} mm and gaps of {printer.gap:g} mm.",
        "",
        "| piece | size | volume in cm³ | thinnest wall in mm | verdict |",
        "|---|---|---|---|---|",
    ]
    for piece in pieces:
        verdict = "printable" if piece.printable else "; ".join(piece.faults)
        lines.append(
            f"| {text_only(piece.name)} | {in_mm(piece.extent)} | {number(piece.volume / 1000)} | "
            f"{piece.wall:.2f} | {text_only(verdict)} |"
        )
    return [
        *lines,
        "",
        f"Every piece fits the bed at `--scale {largest:.3g}` or less.",
        "The files are closed surfaces: that was checked by reading them again. They",
        "are shapes and not a construction kit: pieces run into each other where a joint connects",
        "them, and there is no room for motors, bearings and cables.",
        "",
    ]


def _limits(run: Run) -> list[str]:
    return [
        "## Limits",
        "",
        "- Trained and measured in simulation alone, by one reward, on one kind of ground.",
        *(f"- {text_only(said)}" for said in run.warnings),
        "",
    ]
