"""What one evaluation needs of a machine, and how many of them fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from robomore.errors import InputError


@dataclass(frozen=True, slots=True)
class Resources:
    """What is reserved for each evaluation, as Ray counts it.

    Attributes:
        cores: processor cores. Training uses one.
        memory_bytes: memory, so that a machine does not take more evaluations than it can hold.
        gpu_share: GPUs, or a part of one. The trainers of this package use none.

    Raises:
        InputError: a value makes no sense.
    """

    cores: float = 1.0
    memory_bytes: int = 2**30
    gpu_share: float = 0.0

    def __post_init__(self) -> None:
        if not 0 < self.cores <= _MOST_CORES:
            raise InputError(
                f"{self.cores:g} cores for each evaluation; give a number above 0 and at most "
                f"{_MOST_CORES}"
            )
        if not 2**20 <= self.memory_bytes <= 2**50:
            raise InputError(
                f"{self.memory_bytes} bytes of memory for each evaluation; give at least 1MiB, for "
                "example 2GiB"
            )
        if not 0 <= self.gpu_share <= _MOST_GPUS:
            raise InputError(
                f"{self.gpu_share:g} GPUs for each evaluation; give a number from 0 to {_MOST_GPUS}"
            )

    def __str__(self) -> str:
        gpu = f" and {self.gpu_share:g} of a GPU" if self.gpu_share else ""
        return f"{self.cores:g} cores, {self.memory_bytes / 2**30:.3g} GiB{gpu}"

    def fit(self, node: Mapping[str, float]) -> int:
        """Return how many evaluations a machine takes, by what Ray says that it has."""
        share = node.get("CPU", 0.0) / self.cores
        share = min(share, node.get("memory", 0.0) / self.memory_bytes)
        if self.gpu_share:
            share = min(share, node.get("GPU", 0.0) / self.gpu_share)
        return int(share + 1e-9)


_MOST_CORES, _MOST_GPUS = 1024, 64
