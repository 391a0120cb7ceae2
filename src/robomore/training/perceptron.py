"""A plain multi-layer perceptron, all its parameters one flat vector, as in `networks`."""

from __future__ import annotations

from itertools import pairwise

import jax
import numpy as np
from numpy.typing import NDArray

from robomore.training.networks import Folded, Sizes, unflatten


def initial_parameters(random: np.random.Generator, sizes: Sizes) -> NDArray[np.float32]:
    """Return a flat perceptron, all its numbers uniform within 1 / sqrt(inputs) of zero.

    That is how PyTorch starts a linear layer, so that learning starts where the paper's does.
    """
    parts = [
        random.uniform(-1, 1, inputs * outputs + outputs) / np.sqrt(inputs)
        for inputs, outputs in pairwise(sizes)
    ]
    return np.concatenate(parts).astype(np.float32)


def layers(parameters: jax.Array, sizes: Sizes) -> Folded:
    """Return weight and bias of each layer of a flat perceptron, for `networks.apply`."""
    parts = unflatten(parameters, [((i, o), (o,)) for i, o in pairwise(sizes)])
    return [(weight, bias) for weight, bias in parts]
