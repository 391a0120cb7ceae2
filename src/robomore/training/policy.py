"""A trained policy as plain arrays: runs on NumPy alone and is saved without code in it."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robomore.sandbox.untrusted_files import arrays_in, read_arrays

POLICY = "policy.npz"
"""Name of a policy's file in the folder of whatever it belongs to."""

MOST_LAYERS = 16
"""Layers of a policy, that of its actions among them."""
MOST_BYTES = 64 * 2**20
"""Size of a policy's file; those trained here have less than 1 MiB."""
_HEADERS = 1024
"""Bytes of a policy's file for each array, besides its numbers; NumPy writes some 400."""


def file_bytes(sizes: Sequence[int]) -> int:
    """Return how long a policy's file is at most, in bytes.

    Args:
        sizes: of observations, of each hidden layer, and of actions.
    """
    return sum(4 * (inputs + 1) * outputs + 2 * _HEADERS for inputs, outputs in pairwise(sizes))


@dataclass(frozen=True)
class MLPPolicy:
    """tanh of a multi-layer perceptron with ReLU between its layers: the deterministic policy.

    A trainer folds whatever normalises its inputs into the weights.

    Attributes:
        weights: one (inputs, outputs) float32 array per layer.
        biases: one (outputs,) float32 array per layer.
    """

    weights: tuple[NDArray[np.float32], ...]
    biases: tuple[NDArray[np.float32], ...]

    @property
    def sizes(self) -> tuple[int, ...]:
        """Sizes of observations, of each hidden layer, and of actions."""
        return (self.weights[0].shape[0], *(weight.shape[1] for weight in self.weights))

    def misfit(self, observations: int, actions: int) -> str:
        """Return how it misfits a robot of so many observations and actions; empty if it fits."""
        inputs, *_, outputs = self.sizes
        if (inputs, outputs) == (observations, actions):
            return ""
        return (
            f"takes {inputs} numbers and gives {outputs}, where this robot has {observations} "
            f"observations and {actions} motors"
        )

    @property
    def digest(self) -> str:
        """SHA-256 of sizes, weights and biases, whatever file they came from."""
        found = hashlib.sha256(repr(self.sizes).encode())
        for array in (*self.weights, *self.biases):
            found.update(np.ascontiguousarray(array, np.float32).tobytes())
        return found.hexdigest()

    def act(self, observations: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
        """Return actions (n, actions) in [-1, 1] for `observations` (n, observations)."""
        hidden = np.asarray(observations, dtype=np.float32)
        *inner, last = zip(self.weights, self.biases, strict=True)
        for weight, bias in inner:
            hidden = np.maximum(hidden @ weight + bias, 0)
        actions: NDArray[np.float32] = np.tanh(hidden @ last[0] + last[1])
        return actions

    def to_bytes(self) -> bytes:
        """Return the content of a policy file: `.npz` with `weight0`, `bias0`, `weight1`, …"""
        arrays = {f"weight{i}": weight for i, weight in enumerate(self.weights)}
        arrays |= {f"bias{i}": bias for i, bias in enumerate(self.biases)}
        # As `read_arrays` wants them.
        plain = {name: np.ascontiguousarray(array, np.float32) for name, array in arrays.items()}
        file = io.BytesIO()
        np.savez(file, **plain)  # type: ignore[arg-type]  # numpy types **kwargs as its own flags
        return file.getvalue()

    def save(self, path: Path) -> None:
        """Write a policy file."""
        path.write_bytes(self.to_bytes())

    @classmethod
    def load(cls, path: Path) -> MLPPolicy:
        """Read what `save` wrote, or what untrusted code left in its place. Never unpickles.

        Raises:
            ValueError: the file is not a policy (missing layers, wrong shapes, non-finite numbers).
        """
        return cls._of(read_arrays(path, MOST_BYTES, most_members=2 * MOST_LAYERS), str(path))

    @classmethod
    def from_bytes(cls, content: bytes) -> MLPPolicy:
        """Do what `load` does with the content of a policy file."""
        return cls._of(arrays_in(content, POLICY, MOST_BYTES, 2 * MOST_LAYERS), POLICY)

    @classmethod
    def _of(cls, arrays: dict[str, NDArray[np.float32]], path: str) -> MLPPolicy:
        layers = len(arrays) // 2
        names = {f"{part}{i}" for part in ("weight", "bias") for i in range(layers)}
        if arrays.keys() != names:
            raise ValueError(f"{path} is not a policy: it holds {', '.join(sorted(arrays))}")
        weights = tuple(arrays[f"weight{i}"] for i in range(layers))
        biases = tuple(arrays[f"bias{i}"] for i in range(layers))
        if any(array.ndim != 2 for array in weights) or any(array.ndim != 1 for array in biases):
            raise ValueError(f"{path} is not a policy: its layers are no matrices and vectors")
        if not layers or any(not np.isfinite(array).all() for array in (*weights, *biases)):
            raise ValueError(f"{path} is not a policy: no layers, or numbers that are not finite")
        joined = all(a.shape[1] == b.shape[0] for a, b in pairwise(weights))
        if not joined or any(w.shape[1:] != b.shape for w, b in zip(weights, biases, strict=True)):
            raise ValueError(f"{path} is not a policy: its layers do not fit each other")
        return cls(weights, biases)
