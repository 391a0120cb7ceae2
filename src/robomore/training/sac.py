"""Soft actor-critic (Haarnoja et al. 2018) as the paper uses it: plain networks, target critics.

The critics learn from values that slowly following copies of them give; the weight of the policy's
entropy is learnt. All gradient steps of a round are one compiled scan.
"""

from __future__ import annotations

from functools import lru_cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

from robomore.training import loop, networks, perceptron
from robomore.training.compilation import use_cache
from robomore.training.gaussian import sample
from robomore.training.minibatch import Minibatch, observation_size, take_apart
from robomore.training.networks import Folded, Sizes
from robomore.training.optimiser import Adam, adam_step, initial_adam
from robomore.training.policy import MLPPolicy
from robomore.training.settings import SACSettings
from robomore.training.threads import use_one_thread
from robomore.training.trainer import Progress, VectorEnvProtocol

DECAY = 0.9, 0.999
"""Adam's usual decay of the mean gradient and of the mean squared gradient."""


class Policy(NamedTuple):
    """The policy, and the weight of its entropy, as gradient steps change them."""

    parameters: jax.Array
    adam: Adam
    log_entropy_weight: jax.Array
    entropy_adam: Adam


class Critics(NamedTuple):
    """The critics and the copies that follow them; each array holds one critic a row."""

    parameters: jax.Array
    targets: jax.Array
    adam: Adam


class Learner(NamedTuple):
    """Everything that gradient steps change."""

    policy: Policy
    critics: Critics


class SAC:
    """Trains with soft actor-critic; see `Trainer`."""

    def __init__(self, settings: SACSettings) -> None:
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
        policy = perceptron.initial_parameters(random, sizes.policy)
        critics = np.stack(
            [perceptron.initial_parameters(random, sizes.critic) for _ in range(settings.critics)]
        )
        log_weight = np.log(np.float32(settings.init_alpha))
        # NumPy's arrays become JAX's in the first round.
        learner: Any = (
            (policy, initial_adam(policy), log_weight, initial_adam(log_weight)),
            (critics, critics.copy(), initial_adam(critics)),
        )
        untrained: Any = policy
        acting: Any = perceptron.layers(untrained, sizes.policy)
        return Learner(Policy(*learner[0]), Critics(*learner[1])), acting

    def learn(
        self, learner: Learner, rows: NDArray[np.float32], noise: NDArray[np.float32], done: int
    ) -> tuple[Learner, loop.Layers, dict[str, float]]:
        """Do one round of gradient steps in one compiled call; see `loop.Learning`."""
        learner, acting, losses = _compiled(self.settings)(learner, rows, noise)
        layers = [(np.asarray(weight), np.asarray(bias)) for weight, bias in acting]
        return learner, layers, {name: float(value) for name, value in losses.items()}


@lru_cache
def _compiled(settings: SACSettings) -> Any:
    return jax.jit(partial(_round, settings), donate_argnums=0)


class _Sizes:
    """Sizes of the networks for a robot."""

    def __init__(self, settings: SACSettings, observations: int, actions: int) -> None:
        self.policy: Sizes = (observations, *settings.hidden, 2 * actions)
        self.critic: Sizes = (observations + actions, *settings.hidden, 1)


def _round(
    settings: SACSettings, learner: Learner, rows: jax.Array, noise: jax.Array
) -> tuple[Learner, Folded, dict[str, jax.Array]]:
    """Return the learner after a round, its policy, and losses averaged over the round."""
    actions = noise.shape[-1]
    sizes = _Sizes(settings, observation_size(rows, actions), actions)
    step = partial(_gradient_step, settings, sizes)
    learner, losses = jax.lax.scan(step, learner, (rows, noise))
    acting = perceptron.layers(learner.policy.parameters, sizes.policy)
    return learner, acting, jax.tree.map(jnp.mean, losses)


def _gradient_step(
    settings: SACSettings, sizes: _Sizes, learner: Learner, given: tuple[jax.Array, jax.Array]
) -> tuple[Learner, dict[str, jax.Array]]:
    """One step of the critics, then of policy and entropy weight."""
    rows, (next_noise, noise) = given
    batch = take_apart(rows, noise.shape[-1])
    critics, critic_loss = _learn_critics(settings, sizes, learner, batch, next_noise)
    policy, policy_loss = _learn_policy(
        settings, sizes, learner.policy, critics, batch.observation, noise
    )
    losses = {
        "critic loss": critic_loss,
        "policy loss": policy_loss,
        "entropy weight": jnp.exp(policy.log_entropy_weight),
    }
    return Learner(policy, critics), losses


def _learn_critics(
    settings: SACSettings, sizes: _Sizes, learner: Learner, batch: Minibatch, noise: jax.Array
) -> tuple[Critics, jax.Array]:
    policy, critics = learner
    heads = networks.apply(
        perceptron.layers(policy.parameters, sizes.policy), batch.next_observation
    )
    next_action, density = sample(heads, noise)
    followers = _layers_of_each(critics.targets, sizes)
    next_value = _values(followers, batch.next_observation, next_action).min(axis=0)
    entropy_bonus = -jnp.exp(policy.log_entropy_weight) * density
    target = batch.reward + batch.future * (next_value + entropy_bonus)

    def loss(layers: Folded) -> jax.Array:
        value = _values(layers, batch.observation, batch.action)
        return 0.5 * jnp.square(value - target).mean(axis=1).sum()

    layers = _layers_of_each(critics.parameters, sizes)
    value, gradients = jax.value_and_grad(loss)(layers)
    parameters, adam = adam_step(
        critics.adam,
        critics.parameters,
        jax.vmap(networks.flatten)(gradients),
        settings.rate,
        DECAY,
    )
    targets = critics.targets + settings.tau * (parameters - critics.targets)
    return Critics(parameters, targets, adam), value


def _learn_policy(
    settings: SACSettings,
    sizes: _Sizes,
    policy: Policy,
    critics: Critics,
    observation: jax.Array,
    noise: jax.Array,
) -> tuple[Policy, jax.Array]:
    entropy_weight = jnp.exp(policy.log_entropy_weight)
    judges = _layers_of_each(critics.parameters, sizes)

    def loss(layers: Folded) -> tuple[jax.Array, jax.Array]:
        action, density = sample(networks.apply(layers, observation), noise)
        values = _values(judges, observation, action).min(axis=0)
        return (entropy_weight * density - values).mean(), -density.mean()

    layers = perceptron.layers(policy.parameters, sizes.policy)
    (value, entropy), gradients = jax.value_and_grad(loss, has_aux=True)(layers)
    parameters, adam = adam_step(
        policy.adam, policy.parameters, networks.flatten(gradients), settings.rate, DECAY
    )
    # The weight rises while the entropy is under its target, and falls while it is above.
    wanted = -noise.shape[-1] if settings.target_entropy is None else settings.target_entropy
    log_entropy_weight, entropy_adam = adam_step(
        policy.entropy_adam, policy.log_entropy_weight, entropy - wanted, settings.rate, DECAY
    )
    return Policy(parameters, adam, log_entropy_weight, entropy_adam), value


def _layers_of_each(parameters: jax.Array, sizes: _Sizes) -> Folded:
    return jax.vmap(partial(perceptron.layers, sizes=sizes.critic))(parameters)


def _values(critics: Folded, observation: jax.Array, action: jax.Array) -> jax.Array:
    """Return what each critic thinks of each action, (critics, batch)."""
    inputs = jnp.concatenate([observation, action], axis=1)
    # Shared inputs would make one wide product, whose outputs then have to be transposed.
    inputs = jnp.broadcast_to(inputs, (len(critics[0][0]), *inputs.shape))
    return jax.vmap(networks.apply)(critics, inputs)[..., 0]
