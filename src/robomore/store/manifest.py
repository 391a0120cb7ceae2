"""What a run was asked for, and with which versions: written once, compared at every resume."""

from __future__ import annotations

import platform
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import msgspec

from robomore.errors import RunFolderError
from robomore.settings import RunSettings

FORMAT = 1
"""Raised when a run folder's layout changes."""

_RELEVANT = ("robomore", "mujoco", "gymnasium", "jax", "jaxlib", "numpy")


def package_versions(*more: str) -> dict[str, str]:
    """Return the versions that can change an evaluation's numbers.

    Args:
        more: packages that matter besides those that always do.
    """
    versions = {"python": ".".join(platform.python_version_tuple()[:2])}
    for package in (*_RELEVANT, *more):
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = "absent"
    return versions


@dataclass(frozen=True, slots=True)
class Manifest:
    """The head of a run folder (`run.json`)."""

    task: str
    task_version: int
    preset: str
    designer: str
    provenance: str
    seed: int
    settings: RunSettings
    designer_settings: dict[str, Any] = field(default_factory=dict)
    """What decides the proposals of a designer that has settings of its own, such as the language
    model and how it is used; never a key."""
    versions: dict[str, str] = field(default_factory=package_versions)
    format: int = FORMAT

    def save(self, path: Path) -> None:
        """Write the manifest as JSON, whole or not at all."""
        text = msgspec.json.format(msgspec.json.encode(self), indent=2)
        partial = path.with_suffix(".partial")
        partial.write_bytes(text + b"\n")
        partial.replace(path)

    @classmethod
    def load(cls, path: Path) -> Manifest:
        """Read a manifest.

        Raises:
            RunFolderError: it is damaged, or was written by a newer version.
        """
        try:
            data = path.read_bytes()
            found = msgspec.json.decode(data, type=dict[str, object]).get("format")
            if isinstance(found, int) and found > FORMAT:
                raise RunFolderError(
                    f"{path} has format {found}, this version of RoboMoRe reads up to {FORMAT}; "
                    "install a newer RoboMoRe"
                )
            return msgspec.json.decode(data, type=cls)
        except OSError as error:
            raise RunFolderError(f"{path} cannot be read ({error.strerror})") from None
        except msgspec.DecodeError as error:
            raise RunFolderError(
                f"{path} is damaged ({error}); choose another folder with --out"
            ) from None

    def refuse_other(self, asked: Manifest, folder: Path) -> None:
        """Refuse to continue this run as `asked`, unless both ask for the same numbers.

        Raises:
            RunFolderError: naming what differs and what to do.
        """
        for name in (
            *("task", "task_version", "designer", "designer_settings", "seed"),
            *("settings", "versions"),
        ):
            mine, theirs = getattr(self, name), getattr(asked, name)
            if mine == theirs:
                continue
            remedy = "choose another folder with --out"
            if name in ("task", "designer", "seed"):
                said = f"{name} is {mine!r} there and {theirs!r} here"
            elif name == "settings":
                said = f"its settings (preset {self.preset!r}) differ from these ({asked.preset!r})"
            elif name == "designer_settings":
                said = "its designer was told otherwise: " + _difference(mine, theirs)
            elif name == "task_version":
                said = f"its task has version {mine}, this RoboMoRe has version {theirs}"
            else:
                said = "other package versions made it: " + _difference(mine, theirs)
                remedy += " or install those versions"
            raise RunFolderError(f"{folder} holds another run: {said}; {remedy}")


def _difference(mine: dict[str, Any], theirs: dict[str, Any]) -> str:
    changed = sorted(k for k in mine | theirs if mine.get(k) != theirs.get(k))
    return ", ".join(f"{k} {mine.get(k)} there, {theirs.get(k)} here" for k in changed)
