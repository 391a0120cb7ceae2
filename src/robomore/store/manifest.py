"""What a run was asked for, and with which versions: written once, compared at every resume."""

from __future__ import annotations

import hashlib
import math
import platform
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import msgspec

from robomore.errors import RunFolderError
from robomore.plain_files import read_plain, write_plain
from robomore.plan import Plan, Stage
from robomore.release import VERSION, development_source
from robomore.settings import RunSettings
from robomore.text import to_json
from robomore.types import Start

FORMAT = 3
"""Raised when a run folder's layout changes."""

_MOST_BYTES = 2**24
_MOST_PLACES = 10**6
"""In one stage of a plan; the page draws a cell for each."""
_DIGEST = "digest"
"""Stands last in the file: half of the SHA-256 of all the rest, by which damage is found."""


def package_versions(*more: str) -> dict[str, str]:
    """Return the versions that can change an evaluation's numbers, those of `more` packages too.

    Of a version of RoboMoRe that was not released, a digest of its code as well.
    """
    versions = {"python": ".".join(platform.python_version_tuple()[:2])}
    for package in ("mujoco", "gymnasium", "jax", "jaxlib", "numpy", *more):
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = "absent"
    # Of the code that runs: what was installed once in place may say an older one.
    versions["robomore"] = VERSION
    if source := development_source():
        versions["robomore source"] = source
    return versions


@dataclass(frozen=True, slots=True)
class Manifest:
    """The head of a run folder (`run.json`).

    Attributes:
        task: id of the task.
        task_parts: what the task consisted of, a digest of each part by name
            (`robomore.tasks.fingerprint`).
        preset: name of the settings.
        designer: name of the designer; empty for a method that asks none.
        provenance: one plain sentence on what made the proposals.
        seed: of the run.
        settings: method, trainer and budgets.
        plan: the stages, the final among them.
        designer_settings: what decides the proposals of a designer that has settings of its own,
            such as the language model and how it is used; never a key.
        versions: of the packages that can change the numbers.
        starts: what the search started from besides the reference design.
        format: of the folder.
    """

    task: str
    task_parts: dict[str, str]
    preset: str
    designer: str
    provenance: str
    seed: int
    settings: RunSettings
    plan: Plan
    designer_settings: dict[str, Any] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=package_versions)
    starts: tuple[Start, ...] = ()
    format: int = FORMAT

    def save(self, path: Path) -> None:
        """Write the manifest as JSON, whole or not at all."""
        fields = msgspec.json.decode(to_json(self))
        text = to_json(fields | {_DIGEST: _digest(fields)})
        write_plain(path, msgspec.json.format(text, indent=2) + b"\n")

    @classmethod
    def load(cls, path: Path) -> Manifest:
        """Read a manifest.

        Raises:
            RunFolderError: it is damaged, or was written by another version.
        """
        try:
            fields = msgspec.json.decode(read_plain(path, _MOST_BYTES), type=dict[str, Any])
            version = fields.get("format")
            if isinstance(version, int) and version != FORMAT:
                remedy = "a newer RoboMoRe" if version > FORMAT else "the RoboMoRe that wrote it"
                raise RunFolderError(
                    f"{path} has format {version}, this version of RoboMoRe reads {FORMAT}; "
                    f"install {remedy}, or choose another folder with --out"
                )
            if fields.pop(_DIGEST, None) != _digest(fields):
                raise ValueError("it does not match its digest")
            found = msgspec.convert(fields, cls)
            for stage in found.plan.stages:
                _check_shape(stage)
            return found
        except OSError as error:
            raise RunFolderError(f"{path} cannot be read ({error.strerror})") from None
        except (ValueError, RecursionError) as error:
            raise RunFolderError(
                f"{path} is damaged ({error}); restore it from a copy, or choose another folder "
                "with --out"
            ) from None

    def refuse_other(self, asked: Manifest, folder: Path) -> None:
        """Refuse to continue this run as `asked`, unless both ask for the same numbers.

        Raises:
            RunFolderError: naming what differs and what to do.
        """
        for name in (
            *("task", "task_parts", "designer", "designer_settings", "seed"),
            *("settings", "versions", "starts"),
        ):
            mine, theirs = getattr(self, name), getattr(asked, name)
            if name == "starts":  # the same file may have another name
                mine, theirs = ([s.content for s in one] for one in (mine, theirs))
            if mine == theirs:
                continue
            remedy = "choose another folder with --out"
            if name in ("task", "designer", "seed"):
                said = f"{name} is {mine!r} there and {theirs!r} here"
            elif name == "task_parts":
                parts = sorted(k for k in mine | theirs if mine.get(k) != theirs.get(k))
                said = f"the task {self.task} was edited since ({', '.join(parts)})"
            elif name == "settings":
                said = f"its settings (preset {self.preset!r}) differ from these ({asked.preset!r})"
            elif name == "starts":
                said = f"it started from {len(mine)} given designs, others than these {len(theirs)}"
            elif name == "designer_settings":
                said = "its designer was told otherwise: " + _difference(mine, theirs)
            else:
                said = "other package versions made it: " + _difference(mine, theirs)
                remedy += " or install those versions"
            raise RunFolderError(f"{folder} holds another run: {said}; {remedy}")


def _check_shape(stage: Stage) -> None:
    """Refuse a stage whose places nobody can show.

    Raises:
        ValueError: saying why.
    """
    said = f"its stage {stage.name[:50]!r} has"
    if stage.shape and len(stage.shape) != len(stage.axes):
        raise ValueError(f"{said} {len(stage.axes)} axes and {len(stage.shape)} sizes of them")
    if any(size < 0 for size in stage.shape):
        raise ValueError(f"{said} a size below 0")
    if math.prod(stage.shape) > _MOST_PLACES:
        raise ValueError(f"{said} more than {_MOST_PLACES:,} places")


def _difference(mine: dict[str, Any], theirs: dict[str, Any]) -> str:
    changed = sorted(k for k in mine | theirs if mine.get(k) != theirs.get(k))
    return ", ".join(f"{k} {mine.get(k)} there, {theirs.get(k)} here" for k in changed)


def _digest(fields: dict[str, Any]) -> str:
    return hashlib.sha256(to_json(fields, sort_keys=True)).hexdigest()[:32]
