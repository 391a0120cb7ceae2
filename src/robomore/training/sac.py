"""Soft actor-critic (Haarnoja et al. 2018) as the paper uses it: plain networks, target critics.

The critics learn from values that slowly following copies of them give; the weight of the policy's
entropy is learnt. All gradient steps of a round are one compiled scan.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from robomore.training import networks, perceptron
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
from robomore.training.networks import Folded
from robomore.training.optimiser import Adam, adam_step, initial_adam
from robomore.training.settings import SACSettings

DECAY = 0.9, 0.999
"""Adam's usual decay of the mean gradient and of the mean squared gradient."""


class Actor(NamedTuple):
    """The policy as gradient steps change it, and the weight of its entropy."""

    parameters: jax.Array
    adam: Adam
    alpha: Alpha


class Critics(NamedTuple):
    """The critics and the copies that follow them; each array holds one critic a row."""

    parameters: jax.Array
    targets: jax.Array
    adam: Adam


class TrainState(NamedTuple):
    """Everything that gradient steps change."""

    actor: Actor
    critics: Critics


class SAC(OffPolicyTrainer):
    """Trains with soft actor-critic; see `Trainer`."""

    settings: SACSettings

    def begin(
        self, random: np.random.Generator, observation_size: int, action_size: int
    ) -> tuple[TrainState, Layers]:
        """Return the state before any learning, and its policy; see `OffPolicyTrainer`."""
        settings = self.settings
        sizes = network_sizes(settings, observation_size, action_size)
        # NumPy's arrays become JAX's in the first round.
        actor: Any = perceptron.initial_parameters(random, sizes.actor)
        critics: Any = np.stack(
            [perceptron.initial_parameters(random, sizes.critic) for _ in range(settings.n_critics)]
        )
        state = TrainState(
            Actor(actor, initial_adam(actor), initial_alpha(settings)),
            Critics(critics, critics.copy(), initial_adam(critics)),
        )
        layers: Any = perceptron.layers(actor, sizes.actor)
        return state, layers

    def learn(
        self, state: TrainState, rows: NDArray[np.float32], noise: NDArray[np.float32], done: int
    ) -> tuple[TrainState, Layers, dict[str, float]]:
        """Do one round of gradient steps in one compiled call; see `OffPolicyTrainer`."""
        given = state, rows, noise
        do_round = compiled(f"sac {self.settings}", partial(_round, self.settings), *given)
        state, acting, losses = do_round(*given)
        layers = [(np.asarray(weight), np.asarray(bias)) for weight, bias in acting]
        return state, layers, {name: float(value) for name, value in losses.items()}


def _round(
    settings: SACSettings, state: TrainState, rows: jax.Array, noise: jax.Array
) -> tuple[TrainState, Folded, dict[str, jax.Array]]:
    """Return the state after a round, its policy, and losses averaged over the round."""
    action_size = noise.shape[-1]
    sizes = network_sizes(settings, observation_size(rows, action_size), action_size)
    step = partial(_gradient_step, settings, sizes)
    state, losses = jax.lax.scan(step, state, (rows, noise))
    acting = perceptron.layers(state.actor.parameters, sizes.actor)
    return state, acting, jax.tree.map(jnp.mean, losses)


def _gradient_step(
    settings: SACSettings,
    sizes: NetworkSizes,
    state: TrainState,
    given: tuple[jax.Array, jax.Array],
) -> tuple[TrainState, dict[str, jax.Array]]:
    """One step of the critics, then of actor and entropy weight."""
    rows, (next_noise, noise) = given
    batch = split_rows(rows, noise.shape[-1])
    critics, of_critics = _update_critics(settings, sizes, state, batch, next_noise)
    actor, of_actor = _update_actor(settings, sizes, state.actor, critics, batch.observation, noise)
    losses = {
        "loss/critic": of_critics,
        "loss/actor": of_actor,
        "alpha": jnp.exp(actor.alpha.log),
    }
    return TrainState(actor, critics), losses


def _update_critics(
    settings: SACSettings,
    sizes: NetworkSizes,
    state: TrainState,
    batch: Minibatch,
    noise: jax.Array,
) -> tuple[Critics, jax.Array]:
    actor, critics = state
    heads = networks.apply(perceptron.layers(actor.parameters, sizes.actor), batch.next_observation)
    next_action, log_prob = sample(heads, noise)
    targets = _layers_of_each(critics.targets, sizes)
    next_value = _values(targets, batch.next_observation, next_action).min(axis=0)
    target = soft_target(batch, next_value, entropy_bonus(actor.alpha, log_prob))

    def loss(layers: Folded) -> jax.Array:
        return critic_loss(_values(layers, batch.observation, batch.action), target)

    layers = _layers_of_each(critics.parameters, sizes)
    value, gradients = jax.value_and_grad(loss)(layers)
    parameters, adam = adam_step(
        critics.adam,
        critics.parameters,
        jax.vmap(networks.flatten)(gradients),
        settings.learning_rate,
        DECAY,
    )
    followed = critics.targets + settings.tau * (parameters - critics.targets)
    return Critics(parameters, followed, adam), value


def _update_actor(
    settings: SACSettings,
    sizes: NetworkSizes,
    actor: Actor,
    critics: Critics,
    observation: jax.Array,
    noise: jax.Array,
) -> tuple[Actor, jax.Array]:
    rate = settings.learning_rate
    alpha = jnp.exp(actor.alpha.log)
    critic_layers = _layers_of_each(critics.parameters, sizes)

    def loss(layers: Folded) -> tuple[jax.Array, jax.Array]:
        action, log_prob = sample(networks.apply(layers, observation), noise)
        value = _values(critic_layers, observation, action).min(axis=0)
        return actor_loss(alpha, log_prob, value), -log_prob.mean()

    layers = perceptron.layers(actor.parameters, sizes.actor)
    (value, entropy), gradients = jax.value_and_grad(loss, has_aux=True)(layers)
    parameters, adam = adam_step(
        actor.adam, actor.parameters, networks.flatten(gradients), rate, DECAY
    )
    updated = update_alpha(settings, actor.alpha, entropy, noise.shape[-1], rate, DECAY)
    return Actor(parameters, adam, updated), value


def _layers_of_each(parameters: jax.Array, sizes: NetworkSizes) -> Folded:
    return jax.vmap(partial(perceptron.layers, sizes=sizes.critic))(parameters)


def _values(critics: Folded, observation: jax.Array, action: jax.Array) -> jax.Array:
    """Return the value that each critic gives each action, (n_critics, batch)."""
    inputs = jnp.concatenate([observation, action], axis=1)
    return jax.vmap(networks.apply)(critics, for_each_critic(len(critics[0][0]), inputs))[..., 0]
