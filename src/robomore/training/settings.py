"""Which training algorithms there are, and their settings. Loads no JAX.

A run names an algorithm and overrides single fields (`TrainerSettings`). This module turns that
into the algorithm's own frozen settings, and refuses what it does not know.
"""

from __future__ import annotations

import importlib
import importlib.util
from dataclasses import dataclass
from typing import Annotated, Any

import msgspec

from robomore.errors import InputError
from robomore.identity import content_key
from robomore.registry import Registry
from robomore.sandbox.plugins import is_installed
from robomore.settings import from_options
from robomore.store.manifest import package_versions
from robomore.tasks.own_source import own_source
from robomore.training.policy import MOST_BYTES, MOST_LAYERS, file_bytes
from robomore.training.trainer import Trainer
from robomore.types import TrainerSettings

Count = Annotated[int, msgspec.Meta(ge=1)]
Positive = Annotated[float, msgspec.Meta(gt=0)]
Fraction = Annotated[float, msgspec.Meta(ge=0, lt=1)]
MOST_EVAL_CHECKPOINTS = 16
"""Policies of one training that are looked at."""
EvalCheckpoints = Annotated[int, msgspec.Meta(ge=1, le=MOST_EVAL_CHECKPOINTS)]
PositiveFraction = Annotated[float, msgspec.Meta(gt=0, le=1)]
Steps = Annotated[int, msgspec.Meta(ge=1, le=1000)]
_OBSERVATIONS, _ACTIONS = 1_000, 100
"""More than any robot here has: whether a policy can be kept is asked before a robot is made."""


@dataclass(frozen=True, slots=True)
class OffPolicySettings:
    """What all our trainers share. Names are those of Stable-Baselines3 where it has the setting;
    the defaults are the paper's (its table of SAC training hyperparameters)."""

    num_envs: Count = 16
    """Environments that are stepped together. All of them simulate the same morphology."""
    train_freq: Count = 8
    """Control steps of every environment between two rounds of gradient steps."""
    gradient_steps: Count = 4
    """Gradient steps in one round."""
    learning_starts: Count = 10_000
    """Control steps with uniformly random actions before learning starts, over all environments."""
    buffer_size: Count = 2_000_000
    """Transitions that the replay buffer holds; the oldest are overwritten."""
    batch_size: Count = 1024
    """Transitions in one gradient step."""
    net_arch: tuple[Count, ...] = (512, 512)
    """Units of each hidden layer, in the actor and in each critic."""
    n_critics: Count = 2
    """Number of critics."""
    gamma: Fraction = 0.99
    """Discount factor for each control step."""
    init_alpha: Positive = 1.0
    """Weight of the policy's entropy at the start; it is learnt from there."""
    target_entropy: float | None = None
    """Entropy that the weight is steered towards, in nats; `None` for minus the action's size."""
    episode_seconds: Positive | None = None
    """Training episodes are cut off after this time, in simulated seconds; `None` for the task's
    own length."""
    replace_rk4: bool = False
    """Where the task integrates by RK4, train with implicitfast at half the timestep, for half the
    work of simulating. Policies are measured with the task's own integrator all the same."""

    def __post_init__(self) -> None:
        if self.buffer_size < self.num_envs:
            raise InputError(
                f"buffer_size = {self.buffer_size} holds no step of all environments (num_envs = "
                f"{self.num_envs}); give at least {self.num_envs}, or fewer environments"
            )
        if len(self.net_arch) >= MOST_LAYERS:
            raise InputError(
                f"net_arch has {len(self.net_arch)} hidden layers; give {MOST_LAYERS - 1} at most"
            )
        if (size := file_bytes((_OBSERVATIONS, *self.net_arch, _ACTIONS))) > MOST_BYTES:
            raise InputError(
                f"net_arch = {list(self.net_arch)} makes policies of {size / 2**20:,.0f} MiB, and "
                f"{MOST_BYTES // 2**20} MiB can be kept; give fewer units, or fewer layers"
            )

    @property
    def round_steps(self) -> int:
        """Control steps of one round, over all environments."""
        return self.train_freq * self.num_envs


@dataclass(frozen=True, slots=True)
class LoopSettings(OffPolicySettings):
    """What our own training loop (`robomore.training.loop`) adds for our own algorithms."""

    n_steps: Steps = 1
    """Control steps over which rewards are summed before a critic's value stands for the rest."""
    normalize_rewards: bool = False
    """Rewards are clipped, centred and divided by the deviation of their discounted returns, so
    that their unit and offset do not matter (`robomore.training.reward_scale`)."""
    deterministic_env_fraction: Fraction = 0.0
    """Fraction of the environments that act without noise once learning has begun. The policy
    without noise is what is measured in the end, so its own mistakes are seen and unlearnt."""
    observed: Count | None = None
    """Numbers of an observation that the networks see, from its start; `None` for all. A policy
    that is returned takes whole observations and ignores the rest."""
    max_noise_repeat: Count = 1
    """Control steps that one draw of the noise is held at most; 1 draws anew at every step
    (`robomore.training.exploration_noise`)."""
    policy_ema_fraction: Fraction = 0.0
    """The policy that is returned is an exponential moving average over about this last fraction of
    the learning; 0 returns the last policy itself."""
    num_eval_checkpoints: EvalCheckpoints = 1
    """Policies that are returned: one from the end of training, the others from shortly before. The
    one that does best in episodes of their own is measured."""


@dataclass(frozen=True, slots=True)
class CrossQSettings(LoopSettings):
    """Settings of CrossQ (Bhatt et al., ICLR 2024): SAC without target networks, with batch
    renormalisation in their place. `docs/trainer.md` says how the defaults were chosen."""

    gradient_steps: Count = 16
    learning_starts: Count = 5_000
    buffer_size: Count = 1_000_000
    batch_size: Annotated[int, msgspec.Meta(ge=2)] = 128  # a batch of one has no variance
    net_arch: tuple[Count, ...] = (128, 128)
    n_critics: Count = 1
    init_alpha: Positive = 0.1
    episode_seconds: Positive | None = 5.0
    replace_rk4: bool = True
    n_steps: Steps = 3
    normalize_rewards: bool = True
    policy_ema_fraction: Fraction = 0.1
    num_eval_checkpoints: EvalCheckpoints = 4
    min_q_weight: Annotated[float, msgspec.Meta(ge=-1, le=1)] = 0.0
    """Weight of the smallest of several critics' values against their mean: 1 is the usual minimum.
    Below 0, what the critics disagree about counts as good and is tried."""
    num_bins: Annotated[int, msgspec.Meta(ge=0, le=1000)] = 0
    """Ranges of values that a critic tells apart and learns by cross-entropy, which needs
    `normalize_rewards`; 0 for one value and squared errors (`robomore.training.value_bins`)."""
    actor_lr: Positive = 1e-3
    """Adam's learning rate for the actor."""
    critic_lr: Positive = 1e-3
    """Adam's learning rate for the critics."""
    alpha_lr: Positive = 5e-3
    """Adam's learning rate for the weight of the entropy."""
    beta1: Fraction = 0.5
    """Adam's decay of the mean gradient; the low value steadies learning without targets."""
    beta2: Fraction = 0.999
    """Adam's decay of the mean squared gradient."""
    policy_delay: Count = 3
    """The actor learns at every so many gradient steps of the critics."""
    batch_norm_momentum: Fraction = 0.99
    """Decay of the running mean and variance that replace a batch's own when the policy acts."""
    renorm_warmup_steps: Annotated[int, msgspec.Meta(ge=0)] = 100_000
    """Gradient steps with plain batch normalisation, before batch renormalisation corrects it."""

    def __post_init__(self) -> None:
        OffPolicySettings.__post_init__(self)  # with slots, `super()` does not know the class
        if self.num_bins == 1 or (self.num_bins and not self.normalize_rewards):
            raise InputError(
                f"num_bins = {self.num_bins}: critics tell at least 2 ranges of values apart, of "
                "rewards that are normalised; give normalize_rewards=true too, or num_bins=0"
            )
        if self.min_q_weight and self.n_critics == 1:
            raise InputError(
                f"min_q_weight = {self.min_q_weight:g} compares several critics, and n_critics is "
                "1; give n_critics=2 too, or min_q_weight=0"
            )


@dataclass(frozen=True, slots=True)
class SACSettings(LoopSettings):
    """Settings of our own soft actor-critic. The defaults are the paper's, and where the paper says
    nothing those of Stable-Baselines3."""

    learning_rate: Positive = 3e-4
    """Adam's learning rate, for the actor, the critics and the weight of the entropy."""
    tau: PositiveFraction = 0.005
    """How far the target critics move towards the critics in one gradient step (1 copies them)."""


@dataclass(frozen=True, slots=True)
class SB3Settings(OffPolicySettings):
    """Settings of Stable-Baselines3's soft actor-critic, with the defaults of `SACSettings`."""

    learning_rate: Positive = 3e-4
    """Adam's learning rate, for the actor, the critics and the weight of the entropy."""
    tau: PositiveFraction = 0.005
    """How far the target critics move towards the critics in one gradient step (1 copies them)."""


SIMULATION = ("num_envs", "episode_seconds", "replace_rk4")
"""Settings that every algorithm has, since they say what it trains in (see `OffPolicySettings`)."""


@dataclass(frozen=True, slots=True)
class Algorithm:
    """A training algorithm: its settings class, and where its trainer is found when it is needed.

    Attributes:
        settings: frozen dataclass whose fields all have defaults; `SIMULATION` are among them.
        trainer: `module:Class`, called with an instance of `settings`.
        needs: names by which packages are imported that RoboMoRe does not bring. Their versions are
            part of a run's identity.
        remedy: what to do where one of them is missing.
    """

    settings: type[Any]
    trainer: str
    needs: tuple[str, ...] = ()
    remedy: str = ""


def _fault(name: str, found: object) -> str:
    if not isinstance(found, Algorithm):
        return f"is a {type(found).__name__}, no Algorithm"
    missing = [setting for setting in SIMULATION if not hasattr(found.settings, setting)]
    return f"lacks {', '.join(missing)} among its settings" if missing else ""


TRAINERS: Registry[Algorithm] = Registry(
    "trainer",
    "robomore.trainers",
    {
        "crossq": Algorithm(CrossQSettings, "robomore.training.crossq:CrossQ"),
        "sac": Algorithm(SACSettings, "robomore.training.sac:SAC"),
        "sb3": Algorithm(
            SB3Settings,
            "robomore.training.sb3:SB3",
            needs=("stable_baselines3", "torch"),
            remedy='pip install "robomore[sb3]"; it brings PyTorch, and where the small build for '
            "processors alone is wanted, install that one first",
        ),
    },
    _fault,
)
"""Algorithms by name."""


def settings_from(trainer: TrainerSettings) -> Any:
    """Return the algorithm's own settings with `trainer.options` put in.

    Raises:
        InputError: unknown algorithm or option, or a value of the wrong kind or out of range.
    """
    cls = TRAINERS.get(trainer.name).settings
    return from_options(cls, trainer.options, f"trainer {trainer.name}")


def ensure_trainer(trainer: TrainerSettings, steps: int | None = None) -> None:
    """Refuse what cannot be trained, before anything is started. Loads no library.

    Args:
        trainer: what is to train.
        steps: control steps of the shortest training that is wanted.

    Raises:
        InputError: see `settings_from`; a package that the algorithm needs is not installed; or
            nothing would be learnt in `steps`.
    """
    least = least_steps(trainer)
    if steps is not None and steps < least:
        one_round = getattr(settings_from(trainer), "round_steps", 0)
        smaller = "train_freq" if steps < one_round else "learning_starts"
        raise InputError(
            f"trainer {trainer.name} learns nothing in {steps} steps: {_before_learning(trainer)}; "
            f"give it at least {least} (--steps, and --final-steps of a run), or let it learn "
            f"sooner with a smaller --trainer-option {smaller}=NUMBER"
        )
    algorithm = TRAINERS.get(trainer.name)
    missing = [name for name in algorithm.needs if importlib.util.find_spec(name) is None]
    if missing:
        raise InputError(
            f"trainer {trainer.name} needs {' and '.join(missing)}, which is not installed here: "
            f"{algorithm.remedy}"
        )


def least_steps(trainer: TrainerSettings) -> int:
    """Return the control steps of the shortest training in which something is learnt.

    Raises:
        InputError: see `settings_from`.
    """
    settings = settings_from(trainer)
    random: int = getattr(settings, "learning_starts", 0)
    if not isinstance(settings, OffPolicySettings):
        return random + 1
    # It trains in whole rounds. Stable-Baselines3 learns only once these are exceeded.
    begins = random + 1 if isinstance(settings, SB3Settings) else random
    return max(1, -(-begins // settings.round_steps)) * settings.round_steps


def _before_learning(trainer: TrainerSettings) -> str:
    """Return what comes before learning, in words."""
    settings = settings_from(trainer)
    said = f"the first {getattr(settings, 'learning_starts', 0)} are random actions"
    if not isinstance(settings, OffPolicySettings):
        return said
    return (
        f"{said}, and it trains in whole rounds of {settings.round_steps} (train_freq = "
        f"{settings.train_freq} times num_envs = {settings.num_envs})"
    )


def hidden_layers(trainer: TrainerSettings) -> tuple[int, ...] | None:
    """Return the units of each hidden layer of a policy that `trainer` leaves.

    `None` for a trainer that RoboMoRe does not bring, whose policies may have any.
    """
    settings = settings_from(trainer)
    ours = TRAINERS.get(trainer.name).trainer.startswith("robomore.")
    return settings.net_arch if ours and isinstance(settings, OffPolicySettings) else None


def versions_for(trainer: TrainerSettings) -> dict[str, str]:
    """Return the versions that can change the numbers of evaluations that `trainer` trains.

    They are those of packages, and of a trainer that RoboMoRe does not bring a digest of its code
    as it stands on the disk now.

    Raises:
        InputError: unknown algorithm.
    """
    algorithm = TRAINERS.get(trainer.name)
    versions = package_versions(*algorithm.needs)
    modules = (algorithm.trainer.partition(":")[0], algorithm.settings.__module__)
    if code := [_own_code(module) for module in modules if not module.startswith("robomore.")]:
        versions[f"trainer {trainer.name}"] = content_key(code)
    return versions


def _own_code(module: str) -> dict[str, str]:
    """Return the text of a module and of what it imports of its author's, by name."""
    own = module.partition(".")[0]
    return own_source(module, skip=lambda top: top != own and is_installed(top))


def make_trainer(trainer: TrainerSettings) -> Trainer:
    """Return the trainer that `trainer` describes; its libraries are loaded only now.

    Raises:
        InputError: see `ensure_trainer`.
    """
    ensure_trainer(trainer)
    settings = settings_from(trainer)
    module, _, name = TRAINERS.get(trainer.name).trainer.partition(":")
    made: Trainer = getattr(importlib.import_module(module), name)(settings)
    return made
