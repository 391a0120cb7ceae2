"""The answer of a run as plain files that need no RoboMoRe to be read."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

import msgspec

from robomore.errors import RunFolderError
from robomore.plain_files import PlainFolder
from robomore.store.rundir import TASK_CONTENT, RunFolder
from robomore.tasks.portable import task_content
from robomore.tasks.task import Task
from robomore.text import to_json
from robomore.types import Evaluation


def best_seed(evaluations: Sequence[Evaluation], objective: str) -> Evaluation:
    """Return the training seed of a design whose policy is kept, audited and shown.

    Args:
        evaluations: at least one of the design, one for each training seed.
        objective: what is compared.
    """
    return max(evaluations, key=lambda e: (e.ok, e.score(objective) or 0.0))


def save_champion(
    folder: RunFolder, task: Task, retrained: Sequence[Evaluation], objective: str
) -> None:
    """Write `champion/`: the design's files, the best seed's policy.npz, and SHA256SUMS.

    `retrained` holds the champion's evaluations, one for each training seed; `objective` decides
    whose policy is kept.
    """
    best = best_seed(retrained, objective)
    files, partial = folder.files, f"{folder.champion.name}.partial"
    files.remove(partial)
    files.make(partial)
    write_design(folder.path / partial, task, retrained)
    policy = f"{folder.artifacts.name}/{best.artifact}/policy.npz"
    if best.artifact and files.is_file(policy):
        files.write(f"{partial}/policy.npz", files.read(policy))
    write_sums(folder.path / partial)
    files.replace(partial, folder.champion.name)


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
    text = msgspec.json.format(to_json(facts), indent=2)
    files = PlainFolder(path)
    files.write("design.json", text + b"\n")
    files.write("reward.py", design.reward.source.encode())
    files.write("robot.xml", task.mjcf(design.morphology.parameters).encode())
    for name, data in task.assets.items():
        files.write(name, data)
    if content := task_content(task):
        files.write(TASK_CONTENT, content)


def write_sums(path: Path) -> None:
    """Write the SHA-256 of each file in the folder `path`, as `sha256sum --check` reads them."""
    files = PlainFolder(path)
    lines = [f"{_sum(files, name)}  {name}\n" for name in files.names() if name != SUMS]
    files.write(SUMS, "".join(lines).encode())


def check_sums(path: Path) -> None:
    """Refuse a folder whose files are not what was written into it; one without sums passes.

    Raises:
        RunFolderError: naming the file.
    """
    files = PlainFolder(path)
    if not files.is_file(SUMS):
        return
    remedy = f"restore it from a copy, or remove {SUMS} if you changed it on purpose"
    try:
        lines = files.read(SUMS, _MOST_BYTES).decode().splitlines()
        sums = {name: sum for sum, _, name in (line.partition("  ") for line in lines)}
        for name in files.names():
            if name in (*_CONTENT, *sums) and sums.get(name) != _sum(files, name):
                raise RunFolderError(f"{path / name} does not match {SUMS}; {remedy}")
        if missing := sorted(sums.keys() - set(files.names())):
            raise RunFolderError(f"{path / missing[0]} is missing; {remedy}")
    except (OSError, UnicodeDecodeError) as error:
        raise RunFolderError(f"{path / SUMS} cannot be read ({error}); {remedy}") from None


SUMS = "SHA256SUMS"


_CONTENT = ("design.json", "policy.npz", "reward.py", "robot.xml", TASK_CONTENT)
"""What a design consists of; other files in its folder, such as a video, have no sum."""
_MOST_BYTES = 2**20


def _sum(files: PlainFolder, name: str) -> str:
    return hashlib.sha256(files.read(name)).hexdigest()
