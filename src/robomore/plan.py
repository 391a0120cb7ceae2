"""What a search intends: its stages, and the most that each may ask for.

A method says this before it starts. Progress, the time left, the forecast of a language model's
cost, and the report's figures all come from it, so none of them knows any method by name.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from robomore.types import Place

Role = Literal["search", "screening", "final"]
"""What the evaluations of a stage are for: they compete to be the best (`search`), they only help
to choose what is trained (`screening`), or they are the last word (`final`)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """One stage of a search.

    Attributes:
        name: as in `Place.stage` and `Slot.stage`.
        axes: what each number of `Place.index` counts. A stage whose axes are `morphology` and
            `reward` is a grid, which is drawn as a heat map. One whose first axis is `branch`
            goes on in all branches side by side.
        shape: the most along each axis.
        proposals: the most proposals, as (`propose` or `improve`, `morphology` or `reward`, count);
            where a method chooses a kind as it goes, the sum over kinds is the most.
        evaluations: the most evaluations.
        steps: the most control steps of training, over all evaluations together.
        batches: batches of evaluations that have to come one after the other, at most.
        typical: share of `steps` that is usually needed, where a stage may end early.
        role: what its evaluations are for.
        shortest: control steps after which designs are compared for the first time, where that is
            before the end of their training; else 0.
    """

    name: str
    axes: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()
    proposals: tuple[tuple[str, str, int], ...] = ()
    evaluations: int = 0
    steps: int = 0
    batches: int = 1
    typical: float = 1.0
    role: Role = "search"
    shortest: int = 0

    @property
    def is_grid(self) -> bool:
        """Whether its evaluations are the pairs of morphologies and rewards."""
        return self.axes == ("morphology", "reward")


@dataclass(frozen=True, slots=True)
class Plan:
    """The stages of a run in order."""

    stages: tuple[Stage, ...]

    def stage(self, name: str) -> Stage:
        """Return the stage of that name; one without a plan's facts where there is none."""
        return next((stage for stage in self.stages if stage.name == name), Stage(name=name))

    def position(self, place: Place) -> tuple[int, ...]:
        """Return what places are sorted by to stand in the order of the search."""
        names = [stage.name for stage in self.stages]
        stage = names.index(place.stage) if place.stage in names else len(names)
        return (stage, *place.index, place.changed == "reward", place.repeat)

    def moment(self, place: Place) -> tuple[int, ...]:
        """Return what places are sorted by to stand in the order in which they were measured."""
        stage, *_ = self.position(place)
        branches = self.stage(place.stage).axes[:1] == ("branch",)
        index = (*place.index[1:], place.changed == "reward", place.repeat, *place.index[:1])
        return (stage, *index) if branches else self.position(place)

    @property
    def proposals(self) -> Mapping[tuple[str, str], int]:
        """The most proposals by action (`propose`, `improve`) and kind, over all stages."""
        found: Counter[tuple[str, str]] = Counter()
        for stage in self.stages:
            for action, kind, count in stage.proposals:
                found[action, kind] += count
        return found

    def describe(self, place: Place) -> str:
        """Return a place in words, counted from one: `fine: branch 1, cycle 2, new reward`."""
        stage = self.stage(place.stage)
        axes = stage.axes or ("number",) * len(place.index)
        said = [f"{axis} {i + 1}" for axis, i in zip(axes, place.index, strict=False)]
        if stage.role == "final":
            # One finalist needs no number.
            said = said if stage.shape and stage.shape[0] > 1 else []
            said = [place.changed, *said, f"training seed {place.repeat}"]
        else:
            if place.changed:
                said.append(f"new {place.changed}")
            if place.repeat:
                said.append("second training seed")
        return f"{place.stage}: {', '.join(said)}" if said else place.stage
