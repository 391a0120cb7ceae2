"""What soft actor-critic algorithms share: the losses of Haarnoja et al. 2018, and what they read.

An algorithm's own file says what its networks are, and in which order they learn.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from robomore.training.networks import Sizes
from robomore.training.optimiser import Adam, adam_step, initial_adam
from robomore.training.settings import OffPolicySettings


class NetworkSizes(NamedTuple):
    """Sizes of the actor and of each critic."""

    actor: Sizes
    critic: Sizes


class Minibatch(NamedTuple):
    """Columns of some rows of the replay buffer; each (batch, …)."""

    observation: jax.Array
    action: jax.Array
    next_observation: jax.Array
    reward: jax.Array
    bootstrap: jax.Array
    """Factor that the next observation's value counts with; 0 where the episode terminated."""


class Alpha(NamedTuple):
    """The logarithm of the entropy's weight, which is learnt, and its optimiser's state."""

    log: jax.Array
    adam: Adam


def network_sizes(
    settings: OffPolicySettings, observation_size: int, action_size: int, outputs: int = 1
) -> NetworkSizes:
    """Return the sizes of the networks for a robot, whose critics have so many `outputs`."""
    return NetworkSizes(
        actor=(observation_size, *settings.net_arch, 2 * action_size),
        critic=(observation_size + action_size, *settings.net_arch, outputs),
    )


def observation_size(rows: jax.Array, action_size: int) -> int:
    """Return how many numbers of an observation there are in `rows` (…, width) of the buffer."""
    return (rows.shape[-1] - action_size - 2) // 2


def split_rows(rows: jax.Array, action_size: int) -> Minibatch:
    """Return the columns of `rows` (batch, width) in the order of `ReplayBuffer`."""
    size = observation_size(rows, action_size)
    edges = np.cumsum([size, action_size, size])
    observation, action, next_observation, rest = jnp.split(rows, edges, axis=1)
    return Minibatch(observation, action, next_observation, rest[:, 0], rest[:, 1])


def initial_alpha(settings: OffPolicySettings) -> Any:
    """Return the entropy's weight before any learning."""
    log_alpha: Any = np.log(np.float32(settings.init_alpha))
    return Alpha(log_alpha, initial_adam(log_alpha))


def soft_target(batch: Minibatch, next_value: jax.Array, entropy_bonus: jax.Array) -> jax.Array:
    """Return what the critics learn: the reward, and the next state's value with its entropy."""
    return batch.reward + batch.bootstrap * (next_value + entropy_bonus)


def entropy_bonus(alpha: Alpha, log_prob: jax.Array) -> jax.Array:
    """Return what the policy's randomness adds to the value of a state, (batch,)."""
    return -jnp.exp(alpha.log) * log_prob


def critic_loss(values: jax.Array, target: jax.Array) -> jax.Array:
    """Return the critics' squared errors, summed over critics, of values (n_critics, batch)."""
    return 0.5 * jnp.square(values - target).mean(axis=1).sum()


def actor_loss(alpha: jax.Array, log_prob: jax.Array, values: jax.Array) -> jax.Array:
    """Return the loss of actions (batch,): those of high value and low probability are good."""
    return (alpha * log_prob - values).mean()


def update_alpha(
    settings: OffPolicySettings,
    alpha: Alpha,
    entropy: jax.Array,
    action_size: int,
    learning_rate: float,
    decay: tuple[float, float],
) -> Alpha:
    """Return the entropy's weight after one step: it rises while the entropy is below its target.

    Args:
        settings: say what the target is.
        alpha: before the step.
        entropy: mean over a batch, in nats.
        action_size: minus which the target is if the settings have none.
        learning_rate: of Adam.
        decay: of Adam's running mean and mean square.
    """
    target = -action_size if settings.target_entropy is None else settings.target_entropy
    return Alpha(*adam_step(alpha.adam, alpha.log, entropy - target, learning_rate, decay))


def for_each_critic(n_critics: int, inputs: jax.Array) -> jax.Array:
    """Return `inputs` once for each critic.

    Shared inputs would make one wide product, whose outputs then have to be transposed.
    """
    return jnp.broadcast_to(inputs, (n_critics, *inputs.shape))
