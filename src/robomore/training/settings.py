"""Which algorithms there are, and their settings: a docstring under each field, no JAX needed.

A run names an algorithm and overrides single fields (`TrainerSettings`); this module turns that
into the algorithm's own frozen settings, and refuses what it does not know.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
from dataclasses import asdict, dataclass, fields
from importlib.metadata import entry_points
from typing import Annotated, Any

import msgspec

from robomore.errors import InputError
from robomore.training.trainer import Trainer
from robomore.types import TrainerSettings

Count = Annotated[int, msgspec.Meta(ge=1)]
Positive = Annotated[float, msgspec.Meta(gt=0)]
Fraction = Annotated[float, msgspec.Meta(ge=0, lt=1)]
Share = Annotated[float, msgspec.Meta(gt=0, le=1)]


@dataclass(frozen=True, slots=True)
class CrossQSettings:
    """Settings of CrossQ (Bhatt et al., ICLR 2024): SAC without target networks, with batch
    renormalisation in their place."""

    simulations: Count = 16
    """Simulations of the body that are stepped together."""
    train_freq: Count = 128
    """Control steps, over all simulations, between two bouts of learning."""
    gradient_steps: Count = 16
    """Gradient steps of the critics in one bout of learning, all of them in one compiled call."""
    learning_starts: Count = 5_000
    """Control steps with uniformly random actions before learning starts."""
    buffer_size: Count = 1_000_000
    """Transitions that are remembered; the oldest are overwritten."""
    batch_size: Count = 128
    """Transitions in one gradient step."""
    hidden: tuple[Count, ...] = (128, 128)
    """Units of each hidden layer, of the policy and of each critic."""
    critics: Count = 2
    """Critics, whose mean or smallest value is believed, or something between."""
    min_q_weight: Annotated[float, msgspec.Meta(ge=0, le=1)] = 0.0
    """How far the smallest value is believed (1) rather than the mean (0)."""
    actor_lr: Positive = 1e-3
    """Adam's learning rate for the policy."""
    critic_lr: Positive = 1e-3
    """Adam's learning rate for the critics."""
    alpha_lr: Positive = 5e-3
    """Adam's learning rate for the weight of the entropy."""
    beta1: Fraction = 0.5
    """Adam's decay of the mean gradient; the lower value steadies learning without targets."""
    beta2: Fraction = 0.999
    """Adam's decay of the mean squared gradient."""
    discount: Fraction | None = None
    """What a reward one control step later is worth; `None` for what the task says."""
    n_step: Count = 3
    """Control steps over which rewards are summed before a value stands for the rest."""
    episode_seconds: Positive | None = 5.0
    """Episodes of training are cut off after this time, in simulated seconds, so that a robot which
    lies on its back does not fill the memory; `None` for the task's own length."""
    policy_delay: Count = 3
    """The policy learns at every so many gradient steps of the critics."""
    init_alpha: Positive = 0.1
    """Weight of the policy's entropy at the start; it is learnt from there."""
    target_entropy: float | None = None
    """Entropy that the weight is steered towards, in nats; `None` for minus the action's size."""
    batch_norm_momentum: Fraction = 0.99
    """Decay of the running mean and variance that stand in for a batch's own when acting."""
    renorm_warmup_steps: int = 100_000
    """Gradient steps with plain batch normalisation before the correction of batch
    renormalisation sets in."""
    deterministic_env_fraction: Fraction | None = None
    """Share of the simulations that act without noise once learning has begun: what is measured in
    the end is the policy without it, and so its own mistakes are seen and unlearnt. `None` for what
    the task says."""
    policy_ema_fraction: Fraction = 0.1
    """The policy that is returned is an exponential average over about this last share of the
    learning; 0 for the last policy itself."""
    snapshots: Count = 4
    """Policies that are handed out, one from the end of training and the others from shortly
    before; the best on episodes of their own is measured."""


@dataclass(frozen=True, slots=True)
class SACSettings:
    """Settings of our own soft actor-critic; the defaults are the paper's (its Table of SAC
    training hyperparameters), and where it says nothing those of Stable-Baselines3."""

    simulations: Count = 16
    """Simulations of the body that are stepped together."""
    train_freq: Count = 128
    """Control steps, over all simulations, between two bouts of learning: the paper's 8 steps of
    16 environments."""
    gradient_steps: Count = 4
    """Gradient steps in one bout of learning, all of them in one compiled call."""
    learning_starts: Count = 10_000
    """Control steps with uniformly random actions before learning starts."""
    buffer_size: Count = 2_000_000
    """Transitions that are remembered; the oldest are overwritten."""
    batch_size: Count = 1024
    """Transitions in one gradient step."""
    hidden: tuple[Count, ...] = (512, 512)
    """Units of each hidden layer, of the policy and of each critic."""
    critics: Count = 2
    """Critics, the smallest of which is believed."""
    rate: Positive = 3e-4
    """Adam's learning rate, for policy, critics and the weight of the entropy."""
    discount: Fraction | None = 0.99
    """What a reward one control step later is worth; `None` for what the task says."""
    n_step: Count = 1
    """Control steps over which rewards are summed before a value stands for the rest."""
    episode_seconds: Positive | None = None
    """Episodes of training are cut off after this time, in simulated seconds; `None` for the task's
    own length."""
    tau: Share = 0.005
    """How far the critics that give values follow those that learn, in one gradient step."""
    init_alpha: Positive = 1.0
    """Weight of the policy's entropy at the start; it is learnt from there."""
    target_entropy: float | None = None
    """Entropy that the weight is steered towards, in nats; `None` for minus the action's size."""
    deterministic_env_fraction: Fraction | None = 0.0
    """Share of the simulations that act without noise once learning has begun; `None` for what the
    task says."""
    policy_ema_fraction: Fraction = 0.0
    """The policy that is returned is an exponential average over about this last share of the
    learning; 0 for the last policy itself."""
    snapshots: Count = 1
    """Policies that are handed out, one from the end of training and the others from shortly
    before; the best on episodes of their own is measured."""


@dataclass(frozen=True, slots=True)
class SB3Settings:
    """Settings of soft actor-critic through Stable-Baselines3, by the names and with the defaults
    of `SACSettings`, as far as that library has them."""

    simulations: Count = 16
    """Simulations of the body that are stepped together."""
    train_freq: Count = 128
    """Control steps, over all simulations, between two bouts of learning."""
    gradient_steps: Count = 4
    """Gradient steps in one bout of learning."""
    learning_starts: Count = 10_000
    """Control steps with uniformly random actions before learning starts."""
    buffer_size: Count = 2_000_000
    """Transitions that are remembered; the oldest are overwritten."""
    batch_size: Count = 1024
    """Transitions in one gradient step."""
    hidden: tuple[Count, ...] = (512, 512)
    """Units of each hidden layer, of the policy and of each critic."""
    critics: Count = 2
    """Critics, the smallest of which is believed."""
    rate: Positive = 3e-4
    """Adam's learning rate, for policy, critics and the weight of the entropy."""
    discount: Fraction | None = 0.99
    """What a reward one control step later is worth; `None` for what the task says."""
    episode_seconds: Positive | None = None
    """Episodes of training are cut off after this time, in simulated seconds; `None` for the task's
    own length."""
    tau: Share = 0.005
    """How far the critics that give values follow those that learn, in one gradient step."""
    init_alpha: Positive = 1.0
    """Weight of the policy's entropy at the start; it is learnt from there."""
    target_entropy: float | None = None
    """Entropy that the weight is steered towards, in nats; `None` for minus the action's size."""


@dataclass(frozen=True, slots=True)
class Algorithm:
    """One way to train: its settings class, and where its trainer is found when it is needed.

    Attributes:
        settings: frozen dataclass, all fields with defaults, two of them `simulations` and
            `episode_seconds` (`CrossQSettings` says what they are).
        trainer: `module:Class`, called with an instance of `settings`.
        needs: packages that RoboMoRe comes without, by the names they are imported by; their
            versions are part of a run's identity.
        remedy: what to do where one of them is missing.
    """

    settings: type[Any]
    trainer: str
    needs: tuple[str, ...] = ()
    remedy: str = ""


TRAINERS: dict[str, Algorithm] = {
    "crossq": Algorithm(CrossQSettings, "robomore.training.crossq:CrossQ"),
    "sac": Algorithm(SACSettings, "robomore.training.sac:SAC"),
    "sb3": Algorithm(
        SB3Settings,
        "robomore.training.sb3:SB3",
        needs=("stable_baselines3", "torch"),
        remedy='pip install "robomore[sb3]"; it brings PyTorch, and where the small build for '
        "processors alone is wanted, install that one first",
    ),
}
"""Algorithms by name. Others are found as entry points of the group `robomore.trainers`, each an
`Algorithm`."""


def settings_from(trainer: TrainerSettings) -> Any:
    """Return the algorithm's own settings with `trainer.options` put in.

    Raises:
        InputError: unknown algorithm or option, or a value of the wrong kind or out of range.
    """
    cls = _algorithm(trainer.name).settings
    known = [field.name for field in fields(cls)]
    if unknown := sorted(set(trainer.options) - set(known)):
        raise InputError(
            f"trainer {trainer.name} has no option {', '.join(map(repr, unknown))}; "
            f"it takes {', '.join(known)}"
        )
    for name, value in trainer.options.items():
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"trainer {trainer.name}: {name} = {value} is not a finite number")
    try:
        return msgspec.convert({**asdict(cls()), **trainer.options}, cls)
    except msgspec.ValidationError as error:
        raise InputError(f"trainer {trainer.name}: {error}") from None


def ensure_trainer(trainer: TrainerSettings, steps: int | None = None) -> None:
    """Refuse before anything is started what cannot be trained. Loads no library.

    Args:
        trainer: what is to train.
        steps: control steps of the shortest training that is meant.

    Raises:
        InputError: see `settings_from`; a package that the algorithm needs is not installed; or
            nothing would be learnt in `steps`.
    """
    warm_up = getattr(settings_from(trainer), "learning_starts", 0)
    if steps is not None and steps <= warm_up:
        raise InputError(
            f"trainer {trainer.name} learns nothing in {steps} steps: the first {warm_up} are "
            "random actions; give it more --steps, or less of those with "
            "--trainer-option learning_starts=NUMBER"
        )
    algorithm = _algorithm(trainer.name)
    missing = [name for name in algorithm.needs if importlib.util.find_spec(name) is None]
    if missing:
        raise InputError(
            f"trainer {trainer.name} needs {' and '.join(missing)}, which is not installed here: "
            f"{algorithm.remedy}"
        )


def packages_for(trainer: TrainerSettings) -> tuple[str, ...]:
    """Return the packages that this trainer needs besides those of every other.

    Raises:
        InputError: unknown algorithm.
    """
    return _algorithm(trainer.name).needs


def make_trainer(trainer: TrainerSettings) -> Trainer:
    """Return the trainer that `trainer` describes; its libraries are loaded only now.

    Raises:
        InputError: see `ensure_trainer`.
    """
    ensure_trainer(trainer)
    settings = settings_from(trainer)
    module, _, name = _algorithm(trainer.name).trainer.partition(":")
    made: Trainer = getattr(importlib.import_module(module), name)(settings)
    return made


def _algorithm(name: str) -> Algorithm:
    if name in TRAINERS:
        return TRAINERS[name]
    plugins = {point.name: point for point in entry_points(group="robomore.trainers")}
    if name not in plugins:
        names = ", ".join(sorted({*TRAINERS, *plugins}))
        raise InputError(f"there is no trainer {name!r}; choose one of {names}")
    algorithm = plugins[name].load()
    if not isinstance(algorithm, Algorithm):
        raise InputError(f"the entry point of trainer {name!r} is not an Algorithm")
    return algorithm
