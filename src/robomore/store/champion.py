"""The answer of a run as plain files that need no RoboMoRe to be read."""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Sequence
from pathlib import Path

import msgspec

from robomore.errors import RunFolderError
from robomore.store.rundir import RunFolder
from robomore.tasks.task import Task
from robomore.types import Evaluation


def save_champion(
    folder: RunFolder, task: Task, retrained: Sequence[Evaluation], objective: str
) -> None:
    """Write `champion/`: design.json, reward.py, robot.xml, the best seed's policy.npz, and sums.

    `retrained` holds the champion's evaluations, one for each training seed; `objective` decides
    whose policy is kept.
    """
    best = max(retrained, key=lambda e: (e.ok, e.score(objective) or 0.0))
    partial = folder.champion.with_suffix(".partial")
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir()
    write_design(partial, task, retrained)
    if best.artifact:
        policy = folder.artifacts / best.artifact / "policy.npz"
        if policy.is_file():
            shutil.copyfile(policy, partial / "policy.npz")
    write_sums(partial)
    shutil.rmtree(folder.champion, ignore_errors=True)
    partial.replace(folder.champion)


def write_design(path: Path, task: Task, evaluations: Sequence[Evaluation]) -> None:
    """Write design.json, reward.py and robot.xml of one design into the existing folder `path`.

    The evaluations are those of the design, one for each training seed.
    """
    design = evaluations[0].design
    facts = {
        "task": task.id,
        "parameters": task.named(design.morphology.parameters),
        "idea": design.morphology.idea,
        "seeds": [evaluation.job.seed for evaluation in evaluations],
        "fitness": [evaluation.fitness for evaluation in evaluations],
        "efficiency": [evaluation.efficiency for evaluation in evaluations],
        "volume": task.volume(design.morphology.parameters),
    }
    text = msgspec.json.format(msgspec.json.encode(facts), indent=2)
    (path / "design.json").write_bytes(text + b"\n")
    (path / "reward.py").write_text(design.reward.source)
    (path / "robot.xml").write_text(task.mjcf(design.morphology.parameters))


def write_sums(path: Path) -> None:
    """Write the SHA-256 of each file in the folder `path`, as `sha256sum --check` reads them."""
    files = sorted(file for file in path.iterdir() if file.name != SUMS)
    lines = [f"{_sum(file)}  {file.name}\n" for file in files]
    (path / SUMS).write_text("".join(lines))


def check_sums(path: Path) -> None:
    """Refuse a folder whose files are not what was written into it; one without sums passes.

    Raises:
        RunFolderError: naming the file.
    """
    if not (path / SUMS).exists():
        return
    remedy = f"restore it from a copy, or remove {SUMS} if you changed it on purpose"
    try:
        lines = (path / SUMS).read_text(encoding="utf-8").splitlines()
        sums = {name: sum for sum, _, name in (line.partition("  ") for line in lines)}
        for file in sorted(path.iterdir()):
            if file.name != SUMS and sums.get(file.name) != _sum(file):
                raise RunFolderError(f"{file} does not match {SUMS}; {remedy}")
        if missing := sorted(sums.keys() - {file.name for file in path.iterdir()}):
            raise RunFolderError(f"{path / missing[0]} is missing; {remedy}")
    except (OSError, UnicodeDecodeError) as error:
        raise RunFolderError(f"{path / SUMS} cannot be read ({error}); {remedy}") from None


SUMS = "SHA256SUMS"


def _sum(file: Path) -> str:
    with file.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()
