"""Noise for exploration that remembers: neighbouring control steps push the same way.

White noise shakes a heavy body to and fro around where it stands. Pink noise, whose power falls
with frequency, also leans on it for a while, and finds gaits sooner (Eberhard et al., ICLR 2023).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


class PinkNoise:
    """Standard normal numbers, correlated over time.

    A mean of first-order processes whose memories double from one to the next comes close to
    pink noise over as many octaves.

    Attributes:
        state: (octaves, *shape) float32, the processes now.
    """

    def __init__(self, octaves: int, shape: tuple[int, ...], random: np.random.Generator) -> None:
        """Start as if the processes had gone on for ever.

        Args:
            octaves: processes; a single one has no memory and is white.
            shape: of the noise of one control step.
            random: draws.
        """
        self.state = random.standard_normal((octaves, *shape), np.float32)
        memory = np.exp(-1.0 / 2.0 ** np.arange(octaves - 1)) if octaves > 1 else np.zeros(0)
        kept = np.concatenate([[0.0], memory]).reshape(-1, *[1] * len(shape))
        self._kept = kept.astype(np.float32)
        self._fresh = np.sqrt(1 - kept**2).astype(np.float32)
        self._share = np.float32(1 / np.sqrt(octaves))

    def draw(self, random: np.random.Generator) -> NDArray[np.float32]:
        """Return the next control step's noise."""
        fresh = random.standard_normal(self.state.shape, np.float32)
        self.state = self._kept * self.state + self._fresh * fresh
        noise: NDArray[np.float32] = self._share * self.state.sum(axis=0)
        return noise
