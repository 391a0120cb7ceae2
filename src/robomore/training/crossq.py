"""CrossQ (Bhatt et al., ICLR 2024): soft actor-critic without target networks.

States and next states go through the critics in one batch. Batch normalisation then sees the
mixture of both, which is what lets the critics bootstrap from themselves. All gradient steps of a
round are one compiled scan.
"""

from __future__ import annotations

from functools import lru_cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from robomore.training import loop, networks
from robomore.training.compilation import use_cache
from robomore.training.gaussian import sample
from robomore.training.minibatch import Minibatch, observation_size, take_apart
from robomore.training.networks import Folded, Layer, Moments, Sizes
from robomore.training.optimiser import Adam, adam_step, initial_adam
from robomore.training.policy import MLPPolicy
from robomore.training.settings import CrossQSettings
from robomore.training.threads import use_one_thread
from robomore.training.trainer import Progress, VectorEnvProtocol


class Policy(NamedTuple):
    """The policy, and the weight of its entropy, as gradient steps change them."""

    parameters: jax.Array
    moments: jax.Array
    adam: Adam
    log_entropy_weight: jax.Array
    entropy_adam: Adam


class Critics(NamedTuple):
    """The critics as gradient steps change them; each array holds one critic a row."""

    parameters: jax.Array
    moments: jax.Array
    adam: Adam


class Learner(NamedTuple):
    """Everything that gradient steps change."""

    policy: Policy
    critics: Critics


class CrossQ:
    """Trains with CrossQ; see `Trainer`."""

    def __init__(self, settings: CrossQSettings) -> None:
        use_one_thread()
        use_cache()
        self.settings = settings

    def prepare(self, observation_size: int, action_size: int) -> None:
        """Compile for a robot; see `Trainer.prepare`."""
        updates, batch = self.settings.gradient_steps, self.settings.batch_size
        learner, _ = self.begin(np.random.default_rng(0), observation_size, action_size)
        rows = np.zeros((updates, batch, 2 * observation_size + action_size + 2), np.float32)
        self.learn(learner, rows, np.zeros((updates, 2, batch, action_size), np.float32), done=0)

    def train(
        self,
        environment: VectorEnvProtocol,
        steps: int,
        seed: int,
        checkpoint: Path | None = None,
        progress: Progress | None = None,
    ) -> list[MLPPolicy]:
        """Train for `steps` control steps; see `loop.train`."""
        return loop.train(self, self.settings, environment, steps, seed, checkpoint, progress)

    def begin(
        self, random: np.random.Generator, observation_size: int, action_size: int
    ) -> tuple[Learner, loop.Layers]:
        """Return the learner before any learning, and its policy; see `loop.Learning`."""
        settings = self.settings
        sizes = _Sizes(settings, observation_size, action_size)
        policy = networks.initial_parameters(random, sizes.policy)
        critics = np.stack(
            [networks.initial_parameters(random, sizes.critic) for _ in range(settings.critics)]
        )
        critic_moments = np.stack([networks.initial_moments(sizes.critic)] * settings.critics)
        log_weight = np.log(np.float32(settings.init_alpha))
        # NumPy's arrays become JAX's in the first round.
        learner: Any = (
            (
                policy,
                networks.initial_moments(sizes.policy),
                initial_adam(policy),
                log_weight,
                initial_adam(log_weight),
            ),
            (critics, critic_moments, initial_adam(critics)),
        )
        untrained: Any = policy
        layers: Any = networks.layers(untrained, sizes.policy)
        acting = [(layer.weight, layer.bias) for layer in layers]
        return Learner(Policy(*learner[0]), Critics(*learner[1])), acting

    def learn(
        self, learner: Learner, rows: NDArray[np.float32], noise: NDArray[np.float32], done: int
    ) -> tuple[Learner, loop.Layers, dict[str, float]]:
        """Do one round of gradient steps in one compiled call; see `loop.Learning`."""
        numbers = np.arange(done, done + len(rows), dtype=np.int32)
        do_round = _compiled(self.settings, done >= self.settings.renorm_warmup_steps)
        learner, folded, losses = do_round(learner, rows, noise, numbers)
        layers = [(np.asarray(weight), np.asarray(bias)) for weight, bias in folded]
        return learner, layers, {name: float(value) for name, value in losses.items()}


@lru_cache
def _compiled(settings: CrossQSettings, renormalise: bool) -> Any:
    return jax.jit(partial(_round, settings, renormalise), donate_argnums=0)


class _Sizes:
    """Sizes of the networks for a robot."""

    def __init__(self, settings: CrossQSettings, observations: int, actions: int) -> None:
        self.policy: Sizes = (observations, *settings.hidden, 2 * actions)
        self.critic: Sizes = (observations + actions, *settings.hidden, 1)


def _round(
    settings: CrossQSettings,
    renormalise: bool,
    learner: Learner,
    rows: jax.Array,
    noise: jax.Array,
    numbers: jax.Array,
) -> tuple[Learner, Folded, dict[str, jax.Array]]:
    """Return the learner after a round, its folded policy, and losses averaged over the round."""
    actions = noise.shape[-1]
    sizes = _Sizes(settings, observation_size(rows, actions), actions)
    step = partial(_gradient_step, settings, sizes, renormalise)
    learner, losses = jax.lax.scan(step, learner, (rows, noise, numbers))
    return learner, _fold_policy(learner.policy, sizes), jax.tree.map(jnp.mean, losses)


def _gradient_step(
    settings: CrossQSettings,
    sizes: _Sizes,
    renormalise: bool,
    learner: Learner,
    given: tuple[jax.Array, jax.Array, jax.Array],
) -> tuple[Learner, dict[str, jax.Array]]:
    """One step of the critics and, at every `policy_delay`-th, of policy and entropy weight."""
    rows, (next_noise, noise), number = given
    batch = take_apart(rows, noise.shape[-1])
    critics, loss = _learn_critics(settings, sizes, renormalise, learner, batch, next_noise)

    def learn_policy(policy: Policy) -> Policy:
        return _learn_policy(
            settings, sizes, renormalise, policy, critics, batch.observation, noise
        )

    policy = jax.lax.cond(
        number % settings.policy_delay == 0, learn_policy, lambda policy: policy, learner.policy
    )
    entropy_weight = jnp.exp(policy.log_entropy_weight)
    return Learner(policy, critics), {"critic loss": loss, "entropy weight": entropy_weight}


def _learn_critics(
    settings: CrossQSettings,
    sizes: _Sizes,
    renormalise: bool,
    learner: Learner,
    batch: Minibatch,
    noise: jax.Array,
) -> tuple[Critics, jax.Array]:
    policy, critics = learner
    heads = networks.apply(_fold_policy(policy, sizes), batch.next_observation)
    next_action, density = sample(heads, noise)
    entropy_bonus = -jnp.exp(policy.log_entropy_weight) * density
    now = jnp.concatenate([batch.observation, batch.action], axis=1)
    then = jnp.concatenate([batch.next_observation, next_action], axis=1)
    inputs = _for_each_critic(settings, jnp.concatenate([now, then]))
    running = _moments_of_each(critics.moments, sizes.critic)
    in_training = jax.vmap(partial(networks.apply_in_training, renormalise=renormalise))

    def loss(layers: list[Layer]) -> tuple[jax.Array, list[Moments]]:
        values, seen = in_training(layers, running, inputs)
        value, next_value = jnp.split(values[..., 0], 2, axis=1)
        future = batch.future * (aggregate_q(settings, next_value) + entropy_bonus)
        target = jax.lax.stop_gradient(batch.reward + future)
        return 0.5 * jnp.square(value - target).mean(axis=1).sum(), seen

    layers = _layers_of_each(critics.parameters, sizes.critic)
    (value, seen), gradients = jax.value_and_grad(loss, has_aux=True)(layers)
    parameters, adam = adam_step(
        critics.adam,
        critics.parameters,
        jax.vmap(networks.flatten)(gradients),
        settings.critic_lr,
        (settings.beta1, settings.beta2),
    )
    moments = _track(settings, critics.moments, jax.vmap(networks.flatten)(seen))
    return Critics(parameters, moments, adam), value


def _learn_policy(
    settings: CrossQSettings,
    sizes: _Sizes,
    renormalise: bool,
    policy: Policy,
    critics: Critics,
    observation: jax.Array,
    noise: jax.Array,
) -> Policy:
    decay = settings.beta1, settings.beta2
    entropy_weight = jnp.exp(policy.log_entropy_weight)
    running = networks.moments(policy.moments, sizes.policy)
    judges = jax.vmap(networks.fold)(
        _layers_of_each(critics.parameters, sizes.critic),
        _moments_of_each(critics.moments, sizes.critic),
    )

    def loss(layers: list[Layer]) -> tuple[jax.Array, tuple[jax.Array, list[Moments]]]:
        heads, seen = networks.apply_in_training(layers, running, observation, renormalise)
        action, density = sample(heads, noise)
        inputs = _for_each_critic(settings, jnp.concatenate([observation, action], axis=1))
        values = aggregate_q(settings, jax.vmap(networks.apply)(judges, inputs)[..., 0])
        return (entropy_weight * density - values).mean(), (-density.mean(), seen)

    layers = networks.layers(policy.parameters, sizes.policy)
    gradients, (entropy, seen) = jax.grad(loss, has_aux=True)(layers)
    parameters, adam = adam_step(
        policy.adam, policy.parameters, networks.flatten(gradients), settings.actor_lr, decay
    )
    # The weight rises while the entropy is under its target, and falls while it is above.
    wanted = -noise.shape[-1] if settings.target_entropy is None else settings.target_entropy
    log_entropy_weight, entropy_adam = adam_step(
        policy.entropy_adam,
        policy.log_entropy_weight,
        entropy - wanted,
        settings.alpha_lr,
        decay,
    )
    moments = _track(settings, policy.moments, networks.flatten(seen))
    return Policy(parameters, moments, adam, log_entropy_weight, entropy_adam)


def aggregate_q(settings: CrossQSettings, values: jax.Array) -> jax.Array:
    """Return what is believed of what each critic says, (critics, batch)."""
    mean = values.mean(axis=0)
    return mean - settings.min_q_weight * (mean - values.min(axis=0))


def _fold_policy(policy: Policy, sizes: _Sizes) -> Folded:
    return networks.fold(
        networks.layers(policy.parameters, sizes.policy),
        networks.moments(policy.moments, sizes.policy),
    )


def _layers_of_each(parameters: jax.Array, sizes: Sizes) -> list[Layer]:
    return jax.vmap(partial(networks.layers, sizes=sizes))(parameters)


def _moments_of_each(moments: jax.Array, sizes: Sizes) -> list[Moments]:
    return jax.vmap(partial(networks.moments, sizes=sizes))(moments)


def _for_each_critic(settings: CrossQSettings, inputs: jax.Array) -> jax.Array:
    # Shared inputs would make one wide product, whose outputs then have to be transposed.
    return jnp.broadcast_to(inputs, (settings.critics, *inputs.shape))


def _track(settings: CrossQSettings, moments: jax.Array, seen: jax.Array) -> jax.Array:
    return settings.batch_norm_momentum * moments + (1 - settings.batch_norm_momentum) * seen
