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
from robomore.training.gaussian import sample
from robomore.training.networks import Network, Statistics
from robomore.training.optimiser import Adam, adam_step, initial_adam
from robomore.training.policy import MLPPolicy
from robomore.training.settings import CrossQSettings
from robomore.training.threads import use_one_thread
from robomore.training.trainer import Progress, VectorEnvironment


class Learner(NamedTuple):
    """Everything that gradient steps change. The critics' arrays hold one critic a row."""

    policy: Network
    policy_statistics: Statistics
    policy_adam: Adam
    critics: Network
    critic_statistics: Statistics
    critic_adam: Adam
    log_entropy_weight: jax.Array
    entropy_adam: Adam


class Minibatch(NamedTuple):
    """Rows of the replay memory, taken apart; each (batch, …)."""

    observation: jax.Array
    action: jax.Array
    next_observation: jax.Array
    reward: jax.Array
    terminated: jax.Array


class CrossQ:
    """Trains with CrossQ; see `Trainer`."""

    def __init__(self, settings: CrossQSettings) -> None:
        use_one_thread()
        self.settings = settings

    def train(
        self,
        environment: VectorEnvironment,
        steps: int,
        seed: int,
        checkpoint: Path | None = None,
        progress: Progress | None = None,
    ) -> MLPPolicy:
        """Train for `steps` control steps; see `loop.train`."""
        return loop.train(self, self.settings, environment, steps, seed, checkpoint, progress)

    def begin(
        self, random: np.random.Generator, observation_size: int, action_size: int
    ) -> tuple[Learner, loop.Layers]:
        """Return the learner before any learning, and its policy; see `loop.Learning`."""
        hidden = self.settings.hidden
        policy_sizes = (observation_size, *hidden, 2 * action_size)
        critic_sizes = (observation_size + action_size, *hidden, 1)
        policy = networks.initial_network(random, policy_sizes)
        critics = networks.stack(
            [networks.initial_network(random, critic_sizes) for _ in range(self.settings.critics)]
        )
        log_weight = np.log(np.float32(self.settings.initial_entropy_weight))
        learner = Learner(
            policy=policy,
            policy_statistics=networks.initial_statistics(policy_sizes),
            policy_adam=initial_adam(policy),
            critics=critics,
            critic_statistics=networks.stack(
                [networks.initial_statistics(critic_sizes)] * self.settings.critics
            ),
            critic_adam=initial_adam(critics),
            log_entropy_weight=log_weight,
            entropy_adam=initial_adam(log_weight),
        )
        return learner, [(np.asarray(layer.weight), np.asarray(layer.bias)) for layer in policy]

    def learn(
        self, learner: Learner, rows: NDArray[np.float32], noise: NDArray[np.float32], done: int
    ) -> tuple[Learner, loop.Layers, dict[str, float]]:
        """Do one round of gradient steps in one compiled call; see `loop.Learning`."""
        numbers = np.arange(done, done + len(rows), dtype=np.int32)
        learner, folded, losses = _compiled(self.settings)(learner, rows, noise, numbers)
        layers = [(np.asarray(weight), np.asarray(bias)) for weight, bias in folded]
        return learner, layers, {name: float(value) for name, value in losses.items()}


@lru_cache
def _compiled(settings: CrossQSettings) -> Any:
    return jax.jit(partial(_round, settings), donate_argnums=0)


def _round(
    settings: CrossQSettings,
    learner: Learner,
    rows: jax.Array,
    noise: jax.Array,
    numbers: jax.Array,
) -> tuple[Learner, list[tuple[jax.Array, jax.Array]], dict[str, jax.Array]]:
    """Return the learner after a round, its folded policy, and mean losses."""
    step = partial(_gradient_step, settings)
    learner, losses = jax.lax.scan(step, learner, (rows, noise, numbers))
    folded = networks.fold_all(learner.policy, learner.policy_statistics)
    return learner, folded, jax.tree.map(jnp.mean, losses)


def _gradient_step(
    settings: CrossQSettings,
    learner: Learner,
    given: tuple[jax.Array, jax.Array, jax.Array],
) -> tuple[Learner, dict[str, jax.Array]]:
    """One step of the critics and, at every `policy_delay`-th, of policy and entropy weight."""
    rows, (next_noise, noise), number = given
    batch = _take_apart(rows, noise.shape[-1])
    renormalise = (number >= settings.renorm_after).astype(jnp.float32)
    learner, loss = _learn_critics(settings, learner, batch, next_noise, renormalise)
    learner = jax.lax.cond(
        number % settings.policy_delay == 0,
        lambda learner: _learn_policy(settings, learner, batch.observation, noise, renormalise),
        lambda learner: learner,
        learner,
    )
    return learner, {"critic loss": loss, "entropy weight": jnp.exp(learner.log_entropy_weight)}


def _learn_critics(
    settings: CrossQSettings,
    learner: Learner,
    batch: Minibatch,
    noise: jax.Array,
    renormalise: jax.Array,
) -> tuple[Learner, jax.Array]:
    heads = networks.apply(learner.policy, learner.policy_statistics, batch.next_observation)
    next_action, density = sample(heads, noise)
    entropy_bonus = -jnp.exp(learner.log_entropy_weight) * density
    now = jnp.concatenate([batch.observation, batch.action], axis=1)
    then = jnp.concatenate([batch.next_observation, next_action], axis=1)
    inputs = jnp.concatenate([now, then])
    goes_on = settings.discount * (1 - batch.terminated)

    def loss(critics: Network) -> tuple[jax.Array, Statistics]:
        values, seen = _values_in_training(critics, learner.critic_statistics, inputs, renormalise)
        value, next_value = jnp.split(values, 2, axis=1)
        target = batch.reward + goes_on * (next_value.min(axis=0) + entropy_bonus)
        error = value - jax.lax.stop_gradient(target)
        return 0.5 * jnp.square(error).mean(axis=1).sum(), seen

    (value, seen), gradients = jax.value_and_grad(loss, has_aux=True)(learner.critics)
    critics, adam = adam_step(
        learner.critic_adam,
        learner.critics,
        gradients,
        settings.critic_rate,
        settings.beta1,
        settings.beta2,
    )
    statistics = networks.track(learner.critic_statistics, seen, settings.norm_momentum)
    return learner._replace(critics=critics, critic_adam=adam, critic_statistics=statistics), value


def _learn_policy(
    settings: CrossQSettings,
    learner: Learner,
    observation: jax.Array,
    noise: jax.Array,
    renormalise: jax.Array,
) -> Learner:
    weight = jnp.exp(learner.log_entropy_weight)

    def loss(policy: Network) -> tuple[jax.Array, tuple[jax.Array, Statistics]]:
        heads, seen = networks.apply_in_training(
            policy, learner.policy_statistics, observation, renormalise
        )
        action, density = sample(heads, noise)
        inputs = jnp.concatenate([observation, action], axis=1)
        values = jax.vmap(networks.apply, in_axes=(0, 0, None))(
            learner.critics, learner.critic_statistics, inputs
        )[..., 0]
        return (weight * density - values.min(axis=0)).mean(), (-density.mean(), seen)

    gradients, (entropy, seen) = jax.grad(loss, has_aux=True)(learner.policy)
    policy, adam = adam_step(
        learner.policy_adam,
        learner.policy,
        gradients,
        settings.policy_rate,
        settings.beta1,
        settings.beta2,
    )
    # The weight rises while the entropy is under its target and falls while it is above.
    wanted = -noise.shape[-1] if settings.target_entropy is None else settings.target_entropy
    log_weight, entropy_adam = adam_step(
        learner.entropy_adam,
        learner.log_entropy_weight,
        entropy - wanted,
        settings.entropy_rate,
        settings.beta1,
        settings.beta2,
    )
    return learner._replace(
        policy=policy,
        policy_adam=adam,
        policy_statistics=networks.track(learner.policy_statistics, seen, settings.norm_momentum),
        log_entropy_weight=log_weight,
        entropy_adam=entropy_adam,
    )


_values_in_training_of_each = jax.vmap(networks.apply_in_training, in_axes=(0, 0, None, None))


def _values_in_training(
    critics: Network, statistics: Statistics, inputs: jax.Array, renormalise: jax.Array
) -> tuple[jax.Array, Statistics]:
    values, seen = _values_in_training_of_each(critics, statistics, inputs, renormalise)
    return values[..., 0], seen


def _take_apart(rows: jax.Array, actions: int) -> Minibatch:
    """Return the columns of `rows` (batch, width) in the order of `Replay`."""
    observations = (rows.shape[1] - actions - 2) // 2
    edges = np.cumsum([observations, actions, observations])
    observation, action, next_observation, rest = jnp.split(rows, edges, axis=1)
    return Minibatch(observation, action, next_observation, rest[:, 0], rest[:, 1])
