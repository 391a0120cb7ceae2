"""The outcome of an audit as plain data, and its file beside the policy that was audited."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

import msgspec

from robomore.plain_files import PlainFolder
from robomore.text import to_json

AUDIT = "audit.json"
"""Name of an audit's file, in the folder of the policy that it is about."""

FORMAT = 1
_MOST_BYTES = 2**20

Outcome = Literal["passes", "warns", "fails", "skipped"]
"""`fails`: the number is not to be believed. `warns`: it is, but not everywhere. `skipped`: this
check does not apply to this task."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What one check says.

    Attributes:
        check: its name.
        outcome: whether the design passes.
        says: one sentence with the numbers.
        numbers: the same numbers for programs, units in their names.
    """

    check: str
    outcome: Outcome
    says: str
    numbers: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Audit:
    """All verdicts on one policy.

    Attributes:
        task: id of the task.
        policy: `MLPPolicy.digest` of the policy. An audit of another policy says nothing.
        episodes: of each measurement.
        fitness: in the audit's own episodes, in the goal's unit; `None` where the physics diverged.
        volume: of the robot, in m³.
        efficiency: fitness / volume.
        equal_density: what the robot would do if it were made of the reference design's matter:
            `density` in kg/m³, `mass` in kg, `fitness` and `efficiency` as above, with the same
            policy. Without the last two, the physics diverged.
        verdicts: one for each check.
        versions: of the packages that decide the numbers.
        format: of this file.
    """

    task: str
    policy: str
    episodes: int
    fitness: float | None
    volume: float
    efficiency: float | None
    equal_density: dict[str, float]
    verdicts: tuple[Verdict, ...]
    versions: dict[str, str] = field(default_factory=dict)
    format: int = FORMAT

    def as_data(self) -> dict[str, Any]:
        """Return the audit as JSON data, as in its file: `passes`, and all attributes."""
        return {"passes": self.passes, **msgspec.to_builtins(self)}

    @property
    def passes(self) -> bool:
        """Whether no check fails."""
        return not self.failed

    @property
    def failed(self) -> tuple[Verdict, ...]:
        """The verdicts of the checks that fail."""
        return tuple(one for one in self.verdicts if one.outcome == "fails")

    @property
    def warned(self) -> tuple[Verdict, ...]:
        """The verdicts of the checks that warn."""
        return tuple(one for one in self.verdicts if one.outcome == "warns")


def save_audit(files: PlainFolder, name: str, audit: Audit) -> None:
    """Write an audit to the file `name`, whole or not at all."""
    files.write(name, msgspec.json.format(to_json(audit.as_data()), indent=2) + b"\n")


def load_audit(files: PlainFolder, name: str) -> Audit | None:
    """Return the audit in the file `name`; `None` if there is no such file.

    Raises:
        ValueError: the file is no audit, of another format, or holds a number that cannot be.
    """
    if not files.is_file(name):
        return None
    try:
        audit = msgspec.json.decode(files.read(name, _MOST_BYTES), type=Audit)
    except (msgspec.DecodeError, RecursionError, OSError) as error:
        raise ValueError(f"{name} is no audit: {error}") from None
    if audit.format != FORMAT:
        raise ValueError(f"{name} has the format {audit.format}, not {FORMAT}; audit again")
    numbers = [audit.volume, *audit.equal_density.values()]
    numbers += [value for value in (audit.fitness, audit.efficiency) if value is not None]
    numbers += [value for one in audit.verdicts for value in one.numbers.values()]
    if not all(map(math.isfinite, numbers)):
        raise ValueError(f"{name} holds a number that is not finite")
    return audit
