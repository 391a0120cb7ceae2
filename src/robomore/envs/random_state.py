"""Random generators whose state is an array, so that a checkpoint holds it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_LOW = 2**64 - 1


def seed_generator(generator: np.random.Generator, sequence: np.random.SeedSequence) -> None:
    """Start `generator` (PCG64) anew in place, so that whoever holds it sees the new state.

    With `SeedSequence(seed)` it draws what Gymnasium's generator of that seed draws.
    """
    generator.bit_generator.state = np.random.PCG64(sequence).state


def generator_state(generator: np.random.Generator) -> NDArray[np.uint64]:
    """Return the state of a PCG64 generator as (6,) words."""
    state = generator.bit_generator.state
    big = (state["state"]["state"], state["state"]["inc"])
    words = [word for number in big for word in (number >> 64, number & _LOW)]
    return np.array([*words, state["has_uint32"], state["uinteger"]], np.uint64)


def set_generator_state(generator: np.random.Generator, words: NDArray[np.uint64]) -> None:
    """Put a PCG64 generator into the state that `generator_state` returned."""
    high, low, inc_high, inc_low, has_uint32, uinteger = (int(word) for word in words)
    generator.bit_generator.state = {
        "bit_generator": "PCG64",
        "state": {"state": high << 64 | low, "inc": inc_high << 64 | inc_low},
        "has_uint32": has_uint32,
        "uinteger": uinteger,
    }


def has_spawned(generator: np.random.Generator) -> bool:
    """Whether `Generator.spawn` was called, which no state of a generator tells."""
    return getattr(generator.bit_generator.seed_seq, "n_children_spawned", 0) > 0
