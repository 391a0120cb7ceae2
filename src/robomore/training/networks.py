"""Multi-layer perceptrons with batch (re)normalisation before each layer (Ioffe 2017).

A layer's normalised input goes nowhere but into `normalised @ weight + bias`, so normalisation is
folded into that weight and bias and the batch is read for its moments alone. The policy that is
handed out in the end is a plain perceptron, made by the same folding.

All parameters of a network are one flat vector, and so are its running moments: an optimiser then
is a few long loops rather than many short ones, which a compiler is slow to make.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

EPSILON = 1e-3
"""Added to variances: inputs that hardly vary are not blown up."""

LARGEST_RATIO = 3.0
LARGEST_SHIFT = 5.0
"""How far batch renormalisation may correct a batch's deviation (factor) and mean (deviations)."""


class Layer(NamedTuple):
    """Normalisation of the inputs by scale and shift, then a linear map."""

    scale: jax.Array
    shift: jax.Array
    weight: jax.Array
    bias: jax.Array


class Moments(NamedTuple):
    """Mean and variance of a layer's inputs, each (inputs,)."""

    mean: jax.Array
    variance: jax.Array


Sizes = tuple[int, ...]
"""Inputs, units of each hidden layer, outputs."""

Folded = list[tuple[jax.Array, jax.Array]]
"""Weight and bias of each layer, normalisation folded in."""


def initial_parameters(random: np.random.Generator, sizes: Sizes) -> NDArray[np.float32]:
    """Return a flat network: weights normal with variance 1 / inputs, all else neutral."""
    parts: list[NDArray[Any]] = []
    for inputs, outputs in pairwise(sizes):
        weight = random.standard_normal((inputs, outputs)) / np.sqrt(inputs)
        parts += [np.ones(inputs), np.zeros(inputs), weight.ravel(), np.zeros(outputs)]
    return np.concatenate(parts).astype(np.float32)


def initial_moments(sizes: Sizes) -> NDArray[np.float32]:
    """Return flat running moments of standardised inputs."""
    parts = [part for inputs in sizes[:-1] for part in (np.zeros(inputs), np.ones(inputs))]
    return np.concatenate(parts).astype(np.float32)


def layers(parameters: jax.Array, sizes: Sizes) -> list[Layer]:
    """Return the layers of a flat network."""
    shapes = [((i,), (i,), (i, o), (o,)) for i, o in pairwise(sizes)]
    return [Layer(*parts) for parts in unflatten(parameters, shapes)]


def moments(statistics: jax.Array, sizes: Sizes) -> list[Moments]:
    """Return the moments of each layer's inputs."""
    return [Moments(*parts) for parts in unflatten(statistics, [((i,), (i,)) for i in sizes[:-1]])]


def flatten(tree: Any) -> jax.Array:
    """Return layers or moments, or gradients shaped like them, as one flat vector."""
    return jnp.concatenate([leaf.ravel() for leaf in jax.tree.leaves(tree)])


def fold(network: Sequence[Layer], running: Sequence[Moments]) -> Folded:
    """Return what gives on raw inputs what `network` gives on inputs normalised by `running`."""
    folded = []
    for layer, (mean, variance) in zip(network, running, strict=True):
        gain = layer.scale * jax.lax.rsqrt(variance + EPSILON)
        offset = layer.shift - mean * gain
        folded.append((gain[:, None] * layer.weight, layer.bias + offset @ layer.weight))
    return folded


def apply(folded: Folded, inputs: jax.Array) -> jax.Array:
    """Return outputs (batch, outputs) for `inputs` (batch, inputs)."""
    for weight, bias in folded[:-1]:
        inputs = jax.nn.relu(inputs @ weight + bias)
    weight, bias = folded[-1]
    return inputs @ weight + bias


def apply_in_training(
    network: Sequence[Layer], running: Sequence[Moments], inputs: jax.Array, renormalise: bool
) -> tuple[jax.Array, list[Moments]]:
    """Return outputs (batch, outputs), normalised by the batch's own moments, and those moments.

    Args:
        network: layers; gradients flow to them, and to `inputs`.
        running: what batch renormalisation corrects towards.
        inputs: (batch, inputs).
        renormalise: whether to correct.
    """
    seen = []
    for i, (layer, expected) in enumerate(zip(network, running, strict=True)):
        last = i == len(network) - 1
        inputs, found = _in_training(layer, inputs, expected, last, renormalise)
        seen.append(found)
    return inputs, seen


@partial(jax.custom_vjp, nondiff_argnums=(3, 4))
def _in_training(
    layer: Layer, inputs: jax.Array, expected: Moments, last: bool, renormalise: bool
) -> tuple[jax.Array, Moments]:
    """Return one layer's outputs, rectified but for the `last`, and the moments of its inputs."""
    return _forward(layer, inputs, expected, last, renormalise)[0]


def _forward(
    layer: Layer, inputs: jax.Array, expected: Moments, last: bool, renormalise: bool
) -> tuple[tuple[jax.Array, Moments], tuple[Any, ...]]:
    mean = inputs.mean(axis=0)
    variance = jnp.square(inputs - mean).mean(axis=0)
    deviation = jnp.sqrt(variance + EPSILON)
    slope, correction = 1 / deviation, jnp.zeros_like(mean)
    if renormalise:
        usual = jnp.sqrt(expected.variance + EPSILON)
        slope *= jnp.clip(deviation / usual, 1 / LARGEST_RATIO, LARGEST_RATIO)
        correction = jnp.clip((mean - expected.mean) / usual, -LARGEST_SHIFT, LARGEST_SHIFT)
    # Normalised inputs are (inputs - mean) * slope + correction.
    gain = layer.scale * slope
    offset = layer.shift + layer.scale * correction - mean * gain
    weight = gain[:, None] * layer.weight
    outputs = inputs @ weight + (layer.bias + offset @ layer.weight)
    if not last:
        outputs = jnp.maximum(outputs, 0)
    kept = (layer, inputs, outputs, mean, deviation, slope, correction, gain, offset, weight)
    return (outputs, Moments(mean, variance)), kept


def _backward(
    last: bool, renormalise: bool, kept: tuple[Any, ...], cotangents: tuple[jax.Array, Moments]
) -> tuple[Layer, jax.Array, None]:
    """Return the gradients, written out: automatic ones pass over the batch far more often.

    As in batch renormalisation, `slope * deviation` and `correction` are taken as constants.
    """
    layer, inputs, outputs, mean, deviation, slope, correction, gain, offset, weight = kept
    error, _ = cotangents
    if not last:
        error = jnp.where(outputs > 0, error, 0)
    bias = error.sum(axis=0)
    of_weight = inputs.T @ error
    of_offset = layer.weight @ bias
    of_gain = (of_weight * layer.weight).sum(axis=1) - mean * of_offset
    gradients = Layer(
        scale=slope * of_gain + correction * of_offset,
        shift=of_offset,
        weight=gain[:, None] * of_weight + offset[:, None] * bias,
        bias=bias,
    )
    # The inputs also act through their own mean and deviation.
    spread = -gain * of_gain / (jnp.square(deviation) * len(inputs))
    constant = -gain * of_offset / len(inputs) - spread * mean
    return gradients, error @ weight.T + (spread * inputs + constant), None


_in_training.defvjp(_forward, _backward)


def unflatten(flat: jax.Array, shapes: Sequence[Sequence[tuple[int, ...]]]) -> list[Any]:
    """Return groups of arrays of the given shapes, as they lie one after the other in `flat`."""
    groups, start = [], 0
    for group in shapes:
        parts = []
        for shape in group:
            size = int(np.prod(shape))
            parts.append(flat[start : start + size].reshape(shape))
            start += size
        groups.append(parts)
    return groups
