"""Multi-layer perceptrons with batch (re)normalisation before each layer (Ioffe 2017).

A normalised input enters a layer only as `normalised @ weight + bias`, so the normalisation is
folded into that layer's weight and bias rather than applied to the batch: the batch is then read
for its moments alone, gradients flow through small matrices, and the policy that is handed out in
the end is a plain perceptron made by the same function.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

Array = jax.Array | NDArray[Any]

EPSILON = 1e-3
"""Added to variances: inputs that hardly vary are not blown up."""

LARGEST_RATIO = 3.0
LARGEST_SHIFT = 5.0
"""How far batch renormalisation may correct a batch's deviation (factor) and mean (deviations)."""


class Layer(NamedTuple):
    """Normalisation of the inputs, then a linear map."""

    scale: Array
    shift: Array
    weight: Array
    bias: Array


class Moments(NamedTuple):
    """Mean and variance of a layer's inputs, each (inputs,)."""

    mean: Array
    variance: Array


Network = tuple[Layer, ...]
Statistics = tuple[Moments, ...]
Tree = TypeVar("Tree", Network, Statistics)


def initial_network(random: np.random.Generator, sizes: Sequence[int]) -> Network:
    """Return layers between `sizes`, weights normal with variance 1 / inputs, all else neutral."""
    return tuple(
        Layer(
            np.ones(inputs, np.float32),
            np.zeros(inputs, np.float32),
            random.standard_normal((inputs, outputs), np.float32) / np.sqrt(np.float32(inputs)),
            np.zeros(outputs, np.float32),
        )
        for inputs, outputs in pairwise(sizes)
    )


def initial_statistics(sizes: Sequence[int]) -> Statistics:
    """Return running moments of standardised inputs, for a network of `sizes`."""
    return tuple(
        Moments(np.zeros(inputs, np.float32), np.ones(inputs, np.float32)) for inputs in sizes[:-1]
    )


def fold(layer: Layer, moments: Moments) -> tuple[jax.Array, jax.Array]:
    """Return weight and bias that give on raw inputs what `layer` gives on normalised ones."""
    gain = layer.scale / jnp.sqrt(moments.variance + EPSILON)
    return _folded(layer, gain, layer.shift - moments.mean * gain)


def fold_all(network: Network, statistics: Statistics) -> list[tuple[jax.Array, jax.Array]]:
    """Return weight and bias of every layer, its normalisation folded in."""
    return [fold(layer, moments) for layer, moments in zip(network, statistics, strict=True)]


def apply(network: Network, statistics: Statistics, inputs: jax.Array) -> jax.Array:
    """Return outputs (batch, outputs), normalised by the running `statistics`."""
    folded = fold_all(network, statistics)
    for weight, bias in folded[:-1]:
        inputs = jax.nn.relu(inputs @ weight + bias)
    weight, bias = folded[-1]
    return inputs @ weight + bias


def apply_in_training(
    network: Network, statistics: Statistics, inputs: jax.Array, renormalise: jax.Array
) -> tuple[jax.Array, Statistics]:
    """Return outputs (batch, outputs), normalised by the batch's moments, and those moments.

    Args:
        network: layers.
        statistics: running moments, which batch renormalisation corrects towards.
        inputs: (batch, inputs).
        renormalise: 1 to correct, 0 for plain batch normalisation.
    """
    seen = []
    for i, (layer, running) in enumerate(zip(network, statistics, strict=True)):
        if i:
            inputs = jax.nn.relu(inputs)
        mean = inputs.mean(axis=0)
        variance = jnp.square(inputs - mean).mean(axis=0)
        seen.append(Moments(mean, variance))
        deviation = jnp.sqrt(variance + EPSILON)
        expected = jnp.sqrt(running.variance + EPSILON)
        ratio = jnp.clip(deviation / expected, 1 / LARGEST_RATIO, LARGEST_RATIO)
        shift = jnp.clip((mean - running.mean) / expected, -LARGEST_SHIFT, LARGEST_SHIFT)
        ratio = jax.lax.stop_gradient(1 + renormalise * (ratio - 1))
        shift = jax.lax.stop_gradient(renormalise * shift)
        gain = layer.scale * ratio / deviation
        weight, bias = _folded(layer, gain, layer.shift + layer.scale * shift - mean * gain)
        inputs = inputs @ weight + bias
    return inputs, tuple(seen)


def track(statistics: Statistics, seen: Statistics, momentum: float) -> Statistics:
    """Return running moments moved a little towards the ones just `seen`."""
    moved: Statistics = jax.tree.map(
        lambda old, new: momentum * old + (1 - momentum) * new, statistics, seen
    )
    return moved


def stack(trees: Sequence[Tree]) -> Tree:
    """Return one network, or statistics, whose arrays hold all of `trees` along a first axis."""
    stacked: Tree = jax.tree.map(lambda *arrays: np.stack(arrays), *trees)
    return stacked


def _folded(layer: Layer, gain: Array, offset: Array) -> tuple[jax.Array, jax.Array]:
    weight = jnp.asarray(layer.weight)
    return jnp.asarray(gain)[:, None] * weight, jnp.asarray(layer.bias + offset @ weight)
