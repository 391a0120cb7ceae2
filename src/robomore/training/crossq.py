"""CrossQ (Bhatt et al., ICLR 2024): soft actor-critic without target networks.

States and next states go through the critics in one batch. Batch normalisation then sees the
mixture of both, which is what lets the critics bootstrap from themselves. All gradient steps of a
round are one compiled scan.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from robomore.training import networks
from robomore.training.actor_critic import (
    Alpha,
    Minibatch,
    NetworkSizes,
    actor_loss,
    critic_loss,
    entropy_bonus,
    for_each_critic,
    initial_alpha,
    network_sizes,
    observation_size,
    soft_target,
    split_rows,
    update_alpha,
)
from robomore.training.compilation import compiled
from robomore.training.gaussian import sample
from robomore.training.loop import Layers, OffPolicyTrainer
from robomore.training.networks import Folded, Layer, Moments, Sizes
from robomore.training.optimiser import Adam, adam_step, initial_adam
from robomore.training.settings import CrossQSettings
from robomore.training.value_bins import cross_entropy, expected_value


class Actor(NamedTuple):
    """The policy as gradient steps change it, and the weight of its entropy."""

    parameters: jax.Array
    moments: jax.Array
    adam: Adam
    alpha: Alpha


class Critics(NamedTuple):
    """The critics as gradient steps change them; each array holds one critic a row."""

    parameters: jax.Array
    moments: jax.Array
    adam: Adam


class TrainState(NamedTuple):
    """Everything that gradient steps change."""

    actor: Actor
    critics: Critics


class CrossQ(OffPolicyTrainer):
    """Trains with CrossQ; see `Trainer`."""

    settings: CrossQSettings

    def begin(
        self, random: np.random.Generator, observation_size: int, action_size: int
    ) -> tuple[TrainState, Layers]:
        """Return the state before any learning, and its policy; see `OffPolicyTrainer`."""
        settings = self.settings
        sizes = _sizes(settings, observation_size, action_size)
        # NumPy's arrays become JAX's in the first round.
        actor: Any = networks.initial_parameters(random, sizes.actor)
        critics: Any = np.stack(
            [networks.initial_parameters(random, sizes.critic) for _ in range(settings.n_critics)]
        )
        moments: Any = networks.initial_moments(sizes.actor)
        critic_moments: Any = np.stack([networks.initial_moments(sizes.critic)] * len(critics))
        state = TrainState(
            Actor(actor, moments, initial_adam(actor), initial_alpha(settings)),
            Critics(critics, critic_moments, initial_adam(critics)),
        )
        layers: Any = networks.layers(actor, sizes.actor)
        return state, [(layer.weight, layer.bias) for layer in layers]

    def learn(
        self, state: TrainState, rows: NDArray[np.float32], noise: NDArray[np.float32], done: int
    ) -> tuple[TrainState, Layers, dict[str, float]]:
        """Do one round of gradient steps in one compiled call; see `OffPolicyTrainer`."""
        numbers = np.arange(done, done + len(rows), dtype=np.int32)
        late = done >= self.settings.renorm_warmup_steps
        given = state, rows, noise, numbers
        do_round = compiled(
            f"crossq {late} {self.settings}", partial(_round, self.settings, late), *given
        )
        state, folded, losses = do_round(*given)
        layers = [(np.asarray(weight), np.asarray(bias)) for weight, bias in folded]
        means = {name: float(value) for name, value in losses.items()}
        # The actor learns in some of the steps alone, and has no loss in the others.
        of_actor = means.pop("loss/actor") * len(rows)
        if times := np.count_nonzero(numbers % self.settings.policy_delay == 0):
            means["loss/actor"] = of_actor / float(times)
        return state, layers, means


def _round(
    settings: CrossQSettings,
    renormalise: bool,
    state: TrainState,
    rows: jax.Array,
    noise: jax.Array,
    numbers: jax.Array,
) -> tuple[TrainState, Folded, dict[str, jax.Array]]:
    """Return the state after a round, its folded policy, and losses averaged over its steps."""
    action_size = noise.shape[-1]
    sizes = _sizes(settings, observation_size(rows, action_size), action_size)
    step = partial(_gradient_step, settings, sizes, renormalise)
    state, losses = jax.lax.scan(step, state, (rows, noise, numbers))
    return state, _fold_actor(state.actor, sizes), jax.tree.map(jnp.mean, losses)


def _gradient_step(
    settings: CrossQSettings,
    sizes: NetworkSizes,
    renormalise: bool,
    state: TrainState,
    given: tuple[jax.Array, jax.Array, jax.Array],
) -> tuple[TrainState, dict[str, jax.Array]]:
    """One step of the critics and, at every `policy_delay`-th, of actor and entropy weight."""
    rows, (next_noise, noise), number = given
    batch = split_rows(rows, noise.shape[-1])
    critics, of_critics = _update_critics(settings, sizes, renormalise, state, batch, next_noise)

    def update(actor: Actor) -> tuple[Actor, jax.Array]:
        return _update_actor(settings, sizes, renormalise, actor, critics, batch.observation, noise)

    def keep(actor: Actor) -> tuple[Actor, jax.Array]:
        return actor, jnp.zeros(())

    due = number % settings.policy_delay == 0
    actor, of_actor = jax.lax.cond(due, update, keep, state.actor)
    losses = {
        "loss/critic": of_critics,
        "loss/actor": of_actor,
        "alpha": jnp.exp(actor.alpha.log),
    }
    return TrainState(actor, critics), losses


def _update_critics(
    settings: CrossQSettings,
    sizes: NetworkSizes,
    renormalise: bool,
    state: TrainState,
    batch: Minibatch,
    noise: jax.Array,
) -> tuple[Critics, jax.Array]:
    actor, critics = state
    heads = networks.apply(_fold_actor(actor, sizes), batch.next_observation)
    next_action, log_prob = sample(heads, noise)
    bonus = entropy_bonus(actor.alpha, log_prob)
    now = jnp.concatenate([batch.observation, batch.action], axis=1)
    then = jnp.concatenate([batch.next_observation, next_action], axis=1)
    inputs = for_each_critic(settings.n_critics, jnp.concatenate([now, then]))
    running = _moments_of_each(critics.moments, sizes.critic)
    in_training = jax.vmap(partial(networks.apply_in_training, renormalise=renormalise))

    def loss(layers: list[Layer]) -> tuple[jax.Array, list[Moments]]:
        outputs, seen = in_training(layers, running, inputs)
        here, there = jnp.split(outputs, 2, axis=1)
        next_value = aggregate_q(settings, _values(settings, there))
        target = jax.lax.stop_gradient(soft_target(batch, next_value, bonus))
        if settings.num_bins:
            return cross_entropy(here, target), seen
        return critic_loss(here[..., 0], target), seen

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


def _update_actor(
    settings: CrossQSettings,
    sizes: NetworkSizes,
    renormalise: bool,
    actor: Actor,
    critics: Critics,
    observation: jax.Array,
    noise: jax.Array,
) -> tuple[Actor, jax.Array]:
    decay = settings.beta1, settings.beta2
    alpha = jnp.exp(actor.alpha.log)
    running = networks.moments(actor.moments, sizes.actor)
    folded_critics = jax.vmap(networks.fold)(
        _layers_of_each(critics.parameters, sizes.critic),
        _moments_of_each(critics.moments, sizes.critic),
    )

    def loss(layers: list[Layer]) -> tuple[jax.Array, tuple[jax.Array, list[Moments]]]:
        heads, seen = networks.apply_in_training(layers, running, observation, renormalise)
        action, log_prob = sample(heads, noise)
        inputs = jnp.concatenate([observation, action], axis=1)
        outputs = jax.vmap(networks.apply)(
            folded_critics, for_each_critic(settings.n_critics, inputs)
        )
        value = aggregate_q(settings, _values(settings, outputs))
        return actor_loss(alpha, log_prob, value), (-log_prob.mean(), seen)

    layers = networks.layers(actor.parameters, sizes.actor)
    (value, (entropy, seen)), gradients = jax.value_and_grad(loss, has_aux=True)(layers)
    parameters, adam = adam_step(
        actor.adam, actor.parameters, networks.flatten(gradients), settings.actor_lr, decay
    )
    moments = _track(settings, actor.moments, networks.flatten(seen))
    size = noise.shape[-1]
    updated = update_alpha(settings, actor.alpha, entropy, size, settings.alpha_lr, decay)
    return Actor(parameters, moments, adam, updated), value


def _sizes(settings: CrossQSettings, observation_size: int, action_size: int) -> NetworkSizes:
    return network_sizes(settings, observation_size, action_size, outputs=settings.num_bins or 1)


def _values(settings: CrossQSettings, outputs: jax.Array) -> jax.Array:
    """Return the values (…,) that the critics' `outputs` (…, num_bins or 1) stand for."""
    return expected_value(outputs) if settings.num_bins else outputs[..., 0]


def aggregate_q(settings: CrossQSettings, values: jax.Array) -> jax.Array:
    """Return one value (batch,) for what the critics give (n_critics, batch)."""
    mean = values.mean(axis=0)
    return mean - settings.min_q_weight * (mean - values.min(axis=0))


def _fold_actor(actor: Actor, sizes: NetworkSizes) -> Folded:
    return networks.fold(
        networks.layers(actor.parameters, sizes.actor),
        networks.moments(actor.moments, sizes.actor),
    )


def _layers_of_each(parameters: jax.Array, sizes: Sizes) -> list[Layer]:
    return jax.vmap(partial(networks.layers, sizes=sizes))(parameters)


def _moments_of_each(moments: jax.Array, sizes: Sizes) -> list[Moments]:
    return jax.vmap(partial(networks.moments, sizes=sizes))(moments)


def _track(settings: CrossQSettings, moments: jax.Array, seen: jax.Array) -> jax.Array:
    return settings.batch_norm_momentum * moments + (1 - settings.batch_norm_momentum) * seen
