"""How large a study is: what each of its runs gets, and how many seeds there are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from robomore.options import with_options
from robomore.settings import RunSettings, preset
from robomore.suggestions import no_such


@dataclass(frozen=True, slots=True)
class Scale:
    """The size of a study.

    Attributes:
        settings: of every run, but for what its arm changes.
        seeds: runs of each arm on each task.
    """

    settings: RunSettings
    seeds: int

    @property
    def budget_steps(self) -> int:
        """Control steps that each search may use: full trainings for all its evaluations."""
        return self.settings.evaluations * self.settings.candidate.steps


def smoke() -> Scale:
    """Checks that everything works; nothing learns anything."""
    return Scale(with_options(preset("smoke"), evaluations=6), seeds=2)


def quick() -> Scale:
    """Fourteen arms on two tasks with three seeds in about two hours of two cores."""
    settings = with_options(
        preset("quick"),
        method_options={"morphologies": 3, "rewards": 2, "max_cycles": 2, "patience": 2},
        steps=20_000,
        evaluations=10,
        final_steps=30_000,
        final_seeds=1,
    )
    return Scale(settings, seeds=3)


def standard() -> Scale:
    """The runs of the preset `standard`, with three seeds in each final."""
    # With the paper's patience of one cycle, all branches may have ended before the budget has.
    settings = with_options(
        preset("standard"), method_options={"patience": 3}, finalists=1, final_seeds=3
    )
    return Scale(settings, seeds=5)


def paper() -> Scale:
    """The paper's budget for each run."""
    return Scale(preset("paper"), seeds=5)


SCALES: dict[str, Callable[[], Scale]] = {
    "smoke": smoke,
    "quick": quick,
    "standard": standard,
    "paper": paper,
}


def scale(name: str) -> Scale:
    """Return the scale of that name.

    Raises:
        InputError: there is none.
    """
    if name not in SCALES:
        raise no_such("preset", name, SCALES)
    return SCALES[name]()
