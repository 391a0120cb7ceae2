"""A trained design of a run as a folder of files that others can use without RoboMoRe."""

from __future__ import annotations

import json
import logging
import re
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from robomore.envs.compile import compile_model
from robomore.envs.vector_env import VectorEnv
from robomore.errors import ExportFailed, InputError
from robomore.export.card import model_card
from robomore.export.environment import environment_package, package_name, recorded
from robomore.export.folder import ensure_free, write_all
from robomore.export.mjcf import standalone_mjcf
from robomore.export.policies import numpy_module, onnx_bytes
from robomore.export.printing import Piece, Printer, pieces_of
from robomore.export.urdf import MESHES, write_urdf
from robomore.processes import clean_environment
from robomore.rendering.recording import record
from robomore.rendering.video import write_video
from robomore.runs import Run
from robomore.runs.words import in_unit
from robomore.training.policy import MLPPolicy
from robomore.types import Evaluation

Tell = Callable[[str], None]
"""Told in a few words what is made next."""

_NEEDED = ("onnx", "manifold3d", "trimesh", "lxml", "networkx")
_CHECKED_EPISODES = 5
_CHECK_SECONDS = 900.0

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Exported:
    """What an export gave.

    Attributes:
        folder: that was written.
        files: paths in it.
        pieces: of the robot, and whether each can be printed; the last one is the whole.
        fitness: mean of the episodes that the exported code ran, in `unit`.
        recorded: mean of the same episodes as the run recorded them, in `unit`.
        unit: of the task's fitness; empty for a number without one.
    """

    folder: Path
    files: tuple[str, ...]
    pieces: tuple[Piece, ...]
    fitness: float
    recorded: float
    unit: str


def export_run(
    run: Run,
    to: str | Path,
    *,
    printer: Printer | None = None,
    video_seconds: float = 10.0,
    force: bool = False,
    tell: Tell = lambda words: None,
) -> Exported:
    """Write the champion of a run as MJCF, URDF, STL, 3MF, ONNX, Python and a model card.

    No reward is executed. All files are made and checked before the first one is written.

    Args:
        run: whose champion, or whatever stands in its place (`Run.focused`), is exported.
        to: the folder, new or empty.
        printer: what can be printed, and at which scale.
        video_seconds: length of the video at most; 0 for none.
        force: replace an earlier export in the folder.
        tell: is told what is made next.

    Raises:
        InputError: nothing was trained, the folder is taken, or a package is missing.
        ExportFailed: something that was made is not what it should be.
    """
    to, printer = Path(to).expanduser(), printer or Printer()
    printer.check()
    ensure_free(to, force)
    _ensure_packages()
    evaluation, policy, name = _chosen(run)
    task, parameters = run.task, evaluation.design.morphology.parameters
    tell("robot")
    model = compile_model(task, parameters)
    mjcf = standalone_mjcf(task, parameters, model)
    urdf, meshes = write_urdf(model, package_name(task, name))
    tell("policy")
    facts = {
        "task": task.id,
        "evaluation": evaluation.key,
        "fitness": repr(evaluation.fitness),
        "fitness_unit": run.fitness_unit,
        "robomore": run.manifest.versions.get("robomore", ""),
    }
    module = numpy_module(policy, f"{task.id}, {_file_name(name)}")
    files = {
        "robot/robot.xml": mjcf.encode(),
        "robot/robot.urdf": urdf.encode(),
        **{f"robot/{MESHES}/{file}": content for file, content in meshes.items()},
        "policy/policy.onnx": onnx_bytes(policy, facts),
        "policy/policy.py": module.encode(),
    }
    package = environment_package(run, evaluation, _file_name(name), mjcf, module)
    files |= {f"environment/{file}": content for file, content in package.items()}
    tell("episodes, run by the exported code alone")
    again = _run_alone(package, package_name(task, _file_name(name)), evaluation)
    before = evaluation.episode_fitness[: len(again)]
    _warn_if_apart(again, evaluation, run.fitness_unit)
    tell("pieces for a printer")
    pieces = pieces_of(model, printer)
    for piece in pieces:
        files[f"print/{piece.name}.stl"] = piece.stl
        files[f"print/{piece.name}.3mf"] = piece.threemf
    if video_seconds:
        tell("video")
        files["video.webp"] = _video(run, parameters, policy, name, video_seconds)
    card = model_card(
        run,
        evaluation,
        _file_name(name),
        model,
        pieces,
        printer,
        again,
        "video.webp" if video_seconds else "",
    )
    files["README.md"] = card.encode()
    write_all(to, files, {**facts, "pieces": [_facts(piece) for piece in pieces]})
    return Exported(
        to,
        tuple(sorted(files)),
        tuple(pieces),
        float(np.mean(again)),
        float(np.mean(before)),
        run.fitness_unit,
    )


def _ensure_packages() -> None:
    missing = [name for name in _NEEDED if find_spec(name) is None]
    if missing:
        raise InputError(
            f"an export needs more packages ({', '.join(missing)}); install them with "
            "pip install 'robomore[export]'"
        )


def _chosen(run: Run) -> tuple[Evaluation, MLPPolicy, str]:
    """Return what is exported: the best training seed, its policy, and the name of the design.

    Raises:
        InputError: there is nothing to export.
    """
    champion = run.champion
    if champion is None or not champion.trained:
        raise InputError(f"{run.folder} has nothing trained yet; wait, or run it on")
    evaluation = champion.best(run.objective)
    policy = run.load_policy(evaluation.key)
    robot = VectorEnv(run.task, evaluation.design.morphology.parameters, 1)
    if misfit := policy.misfit(robot.observation_size, robot.action_size):
        raise InputError(
            f"the policy of the trainer {evaluation.job.trainer.name!r} {misfit}; one that needs "
            "more than one observation cannot be exported"
        )
    return evaluation, policy, champion.name


def _file_name(name: str) -> str:
    return re.sub(r"[^\w-]+", "-", name, flags=re.ASCII).strip("-") or "design"


def _run_alone(package: Mapping[str, bytes], name: str, evaluation: Evaluation) -> list[float]:
    """Return the fitness of the first episodes as the exported package itself measures it.

    It runs in a process of its own, and executes no reward.
    """
    count = min(_CHECKED_EPISODES, len(recorded(evaluation)["seeds"]))
    with TemporaryDirectory(prefix="robomore-") as scratch:
        for file, content in package.items():
            path = Path(scratch) / file
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(content)
        command = [sys.executable, "-m", name, "--json", "--episodes", str(count)]
        try:
            done = subprocess.run(
                command,
                cwd=scratch,
                # A run's folder may come from anybody: what is made of it gets no keys.
                env=clean_environment() | {"PYTHONDONTWRITEBYTECODE": "1"},
                capture_output=True,
                text=True,
                timeout=_CHECK_SECONDS,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise ExportFailed(
                f"the exported package did not run {count} episodes in {_CHECK_SECONDS:g} s"
            ) from None
    if done.returncode:
        reason = done.stderr.strip().splitlines()[-1:] or ["no reason given"]
        raise ExportFailed(f"the exported package does not run: {reason[0]}")
    found: list[float] = json.loads(done.stdout)
    return found


def _warn_if_apart(again: list[float], evaluation: Evaluation, unit: str) -> None:
    """Warn where the exported code moves the robot otherwise than the run recorded."""
    episodes = evaluation.episode_fitness
    low, high = min(episodes), max(episodes)
    slack = max(1e-6, 0.5 * (high - low))
    if not low - slack <= float(np.mean(again)) <= high + slack:
        log.warning(
            "the exported policy reaches %s where the run recorded %.4g to %s: packages or the "
            "task differ from those of the run",
            in_unit(float(np.mean(again)), "fitness", unit),
            low,
            in_unit(high, "fitness", unit),
        )


def _video(
    run: Run, parameters: tuple[float, ...], policy: MLPPolicy, name: str, seconds: float
) -> bytes:
    recording = record(run.task, parameters, policy.act, f"{run.task.title}, {name}")
    with TemporaryDirectory(prefix="robomore-") as scratch:
        path = Path(scratch) / "video.webp"
        write_video([recording], path, seconds)
        return path.read_bytes()


def _facts(piece: Piece) -> dict[str, object]:
    return {
        "name": piece.name,
        "volume_mm3": piece.volume,
        "extent_mm": piece.extent,
        "thinnest_wall_mm": piece.wall,
        "triangles": piece.triangles,
        "printable": piece.printable,
        "faults": piece.faults,
    }
