"""A gallery: champions of many runs, each in a small folder that needs its run no more.

An entry is a design's folder (`design.json`, `reward.py`, `robot.xml`, `policy.npz`, `SHA256SUMS`)
with `origin.json`, which says what made it, and `audit.json`. `robomore play` and `robomore audit`
read it like any other design.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from statistics import fmean

import msgspec

from robomore.errors import InputError
from robomore.options import settings_words
from robomore.plain_files import PlainFolder, is_plain_name
from robomore.runs.audits import audit_beside, audit_of
from robomore.runs.loading import stored_task
from robomore.runs.run import Run
from robomore.runs.trained import TrainedDesign
from robomore.store import RunFolder
from robomore.store.audit import AUDIT, Audit, load_audit, save_audit
from robomore.store.champion import check_sums, write_design, write_sums
from robomore.tasks import Task
from robomore.text import to_json
from robomore.training.policy import POLICY, MLPPolicy

DESIGN, ORIGIN = "design.json", "origin.json"
_ROLES = ("found", "morphology_only", "reward_only", "reference")
_MOST_BYTES = 2**20


@dataclass(frozen=True, slots=True)
class Origin:
    """What made a champion.

    Attributes:
        preset: name of the run's settings.
        settings: the same in words; empty in entries of older versions.
        method: search method.
        designer: who proposed; empty for a method that asks nobody.
        provenance: the same as one sentence.
        seed: of the run.
        role: which pair of the final the champion is.
        steps: control steps of each training in the final.
        reference_fitness: of the reference design in the same final, one for each seed, in the
            goal's unit.
        reference_efficiency: likewise, over the volume in m³.
        final_fitness: of each pair of the final by its role, one for each seed that trained, in the
            goal's unit; empty in entries of older versions.
        final_efficiency: likewise, over the volume in m³.
        objective: what the run compared; empty in entries of older versions.
        final_score: likewise of the pairs, in the objective.
        versions: of the packages that decide the numbers.
        containment: how rewards were kept in, where that was not strictly; else empty.
    """

    preset: str = ""
    settings: str = ""
    method: str = ""
    designer: str = ""
    provenance: str = ""
    seed: int = 0
    role: str = ""
    steps: int = 0
    reference_fitness: tuple[float, ...] = ()
    reference_efficiency: tuple[float, ...] = ()
    final_fitness: dict[str, tuple[float, ...]] = field(default_factory=dict)
    final_efficiency: dict[str, tuple[float, ...]] = field(default_factory=dict)
    objective: str = ""
    final_score: dict[str, tuple[float, ...]] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)
    containment: str = ""


@dataclass(frozen=True, slots=True)
class Facts:
    """What `design.json` says; see `robomore.store.champion`."""

    task: str
    parameters: dict[str, float]
    volume: float
    fitness: tuple[float | None, ...]
    efficiency: tuple[float | None, ...]
    idea: str = ""
    seeds: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Entry:
    """A champion of a gallery.

    Attributes:
        folder: that it lies in.
        task: that it was trained for.
        facts: parameters, and numbers for each training seed.
        reward: text of its reward.
        origin: what made it; `None` for a design that no run made.
        audit: of its policy; `None` if there is none.
    """

    folder: Path
    task: Task
    facts: Facts
    reward: str
    origin: Origin | None
    audit: Audit | None

    @property
    def fitness(self) -> float | None:
        """Mean over the training seeds, in the goal's unit."""
        return _mean(self.facts.fitness)

    @property
    def efficiency(self) -> float | None:
        """Mean over the training seeds: fitness over the volume in m³."""
        return _mean(self.facts.efficiency)


def is_entry(folder: Path) -> bool:
    """Return whether a folder holds one design."""
    return PlainFolder(folder).is_file(DESIGN)


def load_entry(folder: Path) -> Entry:
    """Read one champion.

    Raises:
        InputError: the folder holds no design, a damaged one, or one of a task that is not here.
        RunFolderError: a file is not what was written.
    """
    files = PlainFolder(folder)
    files.check()
    if not files.is_file(DESIGN):
        raise InputError(f"{folder} has no {DESIGN}; name a folder of `robomore gallery`")
    check_sums(folder)
    try:
        facts = msgspec.json.decode(files.read(DESIGN, _MOST_BYTES), type=Facts)
        task = stored_task(files, facts.task)
        task.check(facts.parameters)
        origin = audit = None
        if files.is_file(ORIGIN):
            origin = msgspec.json.decode(files.read(ORIGIN, _MOST_BYTES), type=Origin)
        reward = files.read("reward.py", _MOST_BYTES).decode()
        audit = load_audit(files, AUDIT)
        if audit is not None or files.is_file(POLICY):
            policy = MLPPolicy.load(folder / POLICY).digest
            if audit is None or audit.policy != policy:
                audit = audit_beside(folder, policy)
    except (ValueError, OSError, RecursionError) as error:
        raise InputError(f"{folder} is damaged ({error}); restore it from a copy") from None
    return Entry(folder, task, facts, reward, origin, audit)


def load_gallery(folder: Path) -> list[Entry]:
    """Read all champions in the folders of `folder`, in the order of their names.

    Raises:
        InputError: there is none, or one cannot be read.
    """
    files = PlainFolder(folder)
    # Plain files may lie beside the champions.
    folders = [name for name in files.names() if files.kind(name) == "folder"]
    names = [name for name in folders if files.is_file(f"{name}/{DESIGN}")]
    if not names:
        raise InputError(f"{folder} is no gallery: no folder in it has a {DESIGN}")
    return [load_entry(folder / name) for name in sorted(names)]


def add_entry(run: Run, gallery: Path) -> Path:
    """Write the champion of a run into a gallery; returns its folder, named after the run's.

    Args:
        run: that is finished, and whose champion was audited.
        gallery: the folder, made if it is not there.

    Raises:
        InputError: there is no champion or no audit, or the gallery has an entry of that name.
    """
    name = run.folder.resolve().name
    if not run.final or run.champion is None:
        raise InputError(f"{run.folder} has no final yet, so no champion; run it on")
    audit = audit_of(run)
    if audit is None:
        raise InputError(f"{run.folder} is not audited; `robomore audit {run.folder}` does it")
    if not is_plain_name(name) or (gallery / name).exists():
        raise InputError(f"{gallery / name} exists; remove it first, or rename the run's folder")
    best, champion, reference = run.kept(), run.champion, run.reference
    manifest = run.manifest
    origin = Origin(
        preset=manifest.preset,
        settings=settings_words(manifest.preset, manifest.settings, run.budget_steps),
        method=manifest.settings.method.name,
        designer=manifest.designer,
        provenance=manifest.provenance,
        seed=manifest.seed,
        role=run.champion_role,
        steps=best.job.steps,
        reference_fitness=_values(reference, "fitness"),
        reference_efficiency=_values(reference, "efficiency"),
        final_fitness={role: _values(getattr(run, role), "fitness") for role in _ROLES},
        final_efficiency={role: _values(getattr(run, role), "efficiency") for role in _ROLES},
        objective=run.objective,
        final_score={role: _values(getattr(run, role), run.objective) for role in _ROLES},
        versions=manifest.versions,
        containment=run.containment,
    )
    kept = RunFolder(run.folder)
    try:
        (gallery / name).mkdir(parents=True)
        write_design(gallery / name, run.task, champion.evaluations)
        files = PlainFolder(gallery / name)
        policy = f"{kept.artifacts.name}/{best.artifact}/{POLICY}"
        files.write(POLICY, kept.files.read(policy))
        files.write(ORIGIN, msgspec.json.format(to_json(origin), indent=2) + b"\n")
        write_sums(gallery / name)
        # Without a sum, since it may be made again.
        save_audit(files, AUDIT, audit)
    except OSError as error:
        raise InputError(
            f"cannot write to {gallery / name} ({error.strerror}); name another --out"
        ) from None
    return gallery / name


def _values(design: TrainedDesign | None, objective: str) -> tuple[float, ...]:
    score = design.score(objective) if design else None
    return score.values if score else ()


def _mean(values: tuple[float | None, ...]) -> float | None:
    known = [value for value in values if value is not None]
    return fmean(known) if known else None
