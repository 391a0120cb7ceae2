"""Gradients that are written out by hand are those that JAX finds; the losses, what they say."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from robomore.training import networks
from robomore.training.actor_critic import (
    Alpha,
    Minibatch,
    actor_loss,
    entropy_bonus,
    soft_target,
    update_alpha,
)
from robomore.training.networks import (
    EPSILON,
    LARGEST_RATIO,
    LARGEST_SHIFT,
    Layer,
    Moments,
    apply_in_training,
)
from robomore.training.optimiser import initial_adam
from robomore.training.settings import CrossQSettings

SIZES = (5, 7, 6, 3)
BATCH = 16


def plain(
    layers: list[Layer], running: list[Moments], inputs: jax.Array, renormalise: bool
) -> jax.Array:
    """Batch (re)normalisation as the paper writes it (Ioffe 2017), with nothing folded."""
    for number, (layer, usual) in enumerate(zip(layers, running, strict=True)):
        mean = inputs.mean(axis=0)
        deviation = jnp.sqrt(inputs.var(axis=0) + EPSILON)
        normal = (inputs - mean) / deviation
        if renormalise:
            spread = jnp.sqrt(usual.variance + EPSILON)
            ratio = jnp.clip(deviation / spread, 1 / LARGEST_RATIO, LARGEST_RATIO)
            shift = jnp.clip((mean - usual.mean) / spread, -LARGEST_SHIFT, LARGEST_SHIFT)
            normal = normal * jax.lax.stop_gradient(ratio) + jax.lax.stop_gradient(shift)
        inputs = (normal * layer.scale + layer.shift) @ layer.weight + layer.bias
        if number < len(layers) - 1:
            inputs = jax.nn.relu(inputs)
    return inputs


@pytest.mark.parametrize("renormalise", [False, True])
def test_gradients_by_hand_are_those_of_the_plain_network(renormalise: bool) -> None:
    random = np.random.default_rng(3)
    flat = networks.initial_parameters(random, SIZES)
    flat = flat + random.normal(0, 0.2, flat.shape).astype(np.float32)
    layers = networks.layers(jnp.asarray(flat), SIZES)
    usual = networks.moments(jnp.asarray(networks.initial_moments(SIZES)), SIZES)
    usual = [Moments(one.mean + 0.3, one.variance * 0.5) for one in usual]
    inputs = jnp.asarray(random.normal(0.5, 1.5, (BATCH, SIZES[0])), jnp.float32)
    target = jnp.asarray(random.normal(size=(BATCH, SIZES[-1])), jnp.float32)

    def by_hand(layers: list[Layer], inputs: jax.Array) -> jax.Array:
        outputs, _ = apply_in_training(layers, usual, inputs, renormalise)
        return jnp.square(outputs - target).sum()

    def expected(layers: list[Layer], inputs: jax.Array) -> jax.Array:
        return jnp.square(plain(layers, usual, inputs, renormalise) - target).sum()

    found = jax.value_and_grad(by_hand, argnums=(0, 1))(layers, inputs)
    wanted = jax.value_and_grad(expected, argnums=(0, 1))(layers, inputs)
    for one, other in zip(jax.tree.leaves(found), jax.tree.leaves(wanted), strict=True):
        np.testing.assert_allclose(one, other, rtol=2e-3, atol=2e-3)


def test_randomness_is_worth_something_in_the_target_and_in_the_loss() -> None:
    log = np.log(np.float32(0.5))
    alpha = Alpha(log, initial_adam(log))
    unlikely = jnp.array([-2.0])
    bonus = entropy_bonus(alpha, unlikely)
    assert bonus.tolist() == pytest.approx([1.0])
    batch = Minibatch(*[jnp.zeros((1, 1))] * 3, reward=jnp.array([3.0]), bootstrap=jnp.array([0.9]))
    assert soft_target(batch, jnp.array([10.0]), bonus).tolist() == pytest.approx([12.9])
    assert actor_loss(jnp.exp(log), unlikely, jnp.array([10.0])) == pytest.approx(-11.0)


@pytest.mark.parametrize(("entropy", "rises"), [(-5.0, True), (1.0, False)])
def test_the_weight_of_the_entropy_rises_where_there_is_too_little(
    entropy: float, rises: bool
) -> None:
    log = np.log(np.float32(0.5))
    settings = CrossQSettings()
    alpha = Alpha(log, initial_adam(log))
    after = update_alpha(settings, alpha, jnp.float32(entropy), 2, 1e-2, (0.5, 0.999))
    assert (after.log > log) == rises
