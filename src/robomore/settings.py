"""Everything that a run can be told, as typed values; presets are functions that return them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from robomore.errors import InputError
from robomore.types import TrainerSettings


@dataclass(frozen=True, slots=True)
class Rung:
    """A stop on the way to a candidate's full training, where the worst are cut."""

    share: float
    """Of the full steps that everyone still in the race is trained for."""
    kept: float
    """Share of the grid's pairs that go on from here; at least one does."""


@dataclass(frozen=True, slots=True)
class Screening:
    """How training is kept for the pairs of the grid that deserve it (`search/screening.py`)."""

    rungs: tuple[Rung, ...] = (Rung(share=0.2, kept=0.25), Rung(share=0.4, kept=0.1))
    """Rising shares of training; what is kept at the last one is trained to the end."""
    prefilter_fraction: float = 0.4
    """Share of the bodies, worst under the reference reward at the first rung, that get fewer
    rewards tried; 0 treats all alike and saves that look."""
    prefiltered_rewards: int = 1
    """Rewards tried on each of those, the first ones proposed."""


SCREENINGS: dict[str, Screening | None] = {"halving": Screening(), "none": None}
"""Ways to screen by name."""


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """Sizes of the search (paper, Table 4) and what it optimises."""

    morphologies: int = 25
    """Rows of the coarse grid (N_M)."""
    rewards: int = 5
    """Columns of the coarse grid (N_R)."""
    survivors: float = 0.05
    """Share of the grid that the fine stage starts from (k); at least one design."""
    screening: Screening | None = None
    """How the grid is thinned out on the way; `None` trains every pair to the end (the paper)."""
    max_cycles: int = 10
    """Bound on the fine stage's cycles. The paper stops only when a cycle improved nothing."""
    objective: Literal["efficiency", "fitness"] = "efficiency"
    """What is compared. The paper optimises efficiency."""
    finalists: int = 1
    """How many of the best designs are retrained for the final comparison; the paper takes one."""
    repeats: int = 4
    """Training seeds of each finalist and of the human design. The paper says four."""


@dataclass(frozen=True, slots=True)
class Budget:
    """How much training and measuring one evaluation gets."""

    steps: int
    """Control steps of training, over all simulations together."""
    episodes: int = 10
    """Episodes of the measurement, each with its own seed."""


@dataclass(frozen=True, slots=True)
class RunSettings:
    """All that decides a run's numbers, but for task, designer and seed."""

    search: SearchSettings
    trainer: TrainerSettings
    candidate: Budget
    """What every candidate of the search gets."""
    final: Budget
    """What the finalists and the human design get, once for each training seed."""


def smoke() -> RunSettings:
    """Plumbing in under a minute: every stage runs, nothing learns much."""
    return RunSettings(
        search=SearchSettings(
            morphologies=2, rewards=2, survivors=0.25, max_cycles=1, finalists=1, repeats=1
        ),
        trainer=TrainerSettings("crossq", {"learning_starts": 512}),
        candidate=Budget(steps=2_048, episodes=2),
        final=Budget(steps=2_048, episodes=2),
    )


def quick() -> RunSettings:
    """About five minutes on two cores, with a result worth looking at."""
    return RunSettings(
        search=SearchSettings(
            morphologies=5, rewards=3, survivors=0.1, max_cycles=2, finalists=1, repeats=2
        ),
        trainer=TrainerSettings("crossq"),
        candidate=Budget(steps=30_000, episodes=5),
        final=Budget(steps=30_000, episodes=10),
    )


def standard() -> RunSettings:
    """The paper's 25 x 5 grid, screened, with a trainer that needs about a minute of one core."""
    return RunSettings(
        search=SearchSettings(screening=Screening(), finalists=2, repeats=3),
        trainer=TrainerSettings("crossq"),
        candidate=Budget(steps=150_000, episodes=10),
        final=Budget(steps=300_000, episodes=20),
    )


def paper() -> RunSettings:
    """The paper's budget: 5e5 steps a candidate, 1e6 for the winner, 100 episodes."""
    return RunSettings(
        search=SearchSettings(),
        trainer=TrainerSettings("crossq"),
        candidate=Budget(steps=500_000, episodes=100),
        final=Budget(steps=1_000_000, episodes=100),
    )


PRESETS: dict[str, Callable[[], RunSettings]] = {
    "smoke": smoke,
    "quick": quick,
    "standard": standard,
    "paper": paper,
}


def with_trainer(
    settings: RunSettings,
    name: str | None = None,
    options: Mapping[str, Any] = {},
) -> RunSettings:
    """Return `settings` with another trainer, or with other options for the one they have.

    Options belong to an algorithm: another one than that of `settings` starts from its own
    defaults, and what `settings` say of the old one is dropped.

    Args:
        settings: a preset, say.
        name: of an algorithm (`robomore.training.settings`); `None` for that of `settings`.
        options: fields of the algorithm's settings by name.
    """
    trainer = settings.trainer
    if name is not None and name != trainer.name:
        trainer = TrainerSettings(name)
    trainer = replace(trainer, options={**trainer.options, **options})
    return replace(settings, trainer=trainer)


def preset(name: str) -> RunSettings:
    """Return the settings of a preset.

    Raises:
        InputError: there is no preset of that name.
    """
    if name not in PRESETS:
        raise InputError(f"unknown preset {name!r}; choose one of {', '.join(PRESETS)}")
    return PRESETS[name]()
