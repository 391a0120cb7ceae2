"""The mesh of generated ground: Perlin-type noise, made from a seed, stored nowhere.

One square tile of noise is periodic, so that copies of it, laid side by side, join without a seam.
The tile meets the statistics of the paper's terrains (mean, deviation, half-correlation length and
slope); where those are measured, so is ours: on the tile itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from robomore.tasks.task import Terrain
from robomore.tasks.terrain import CELLS, TILE

FINER = 3
"""Lattice cells of the fine noise for each of the coarse one's."""


@lru_cache(maxsize=8)
def tile(terrain: Terrain) -> NDArray[np.float64]:
    """Return the elevations of one tile as fractions of `terrain.height`.

    Returns:
        (CELLS + 1, CELLS + 1) in [0, 1], rows along y and columns along x, read-only; the last row
        and column repeat the first.
    """
    # A coarse noise with a finer one on top: for each lattice, the share of the finer noise that
    # gives the right slope; of all lattices, the one whose correlation length then fits best.
    fields = [_mixed(terrain, waves) for waves in range(4, 24)]
    best = min(fields, key=lambda field: _misfit(field, terrain))
    closed = np.pad(best, (0, 1), mode="wrap")
    closed.setflags(write=False)
    return closed


def highest(terrain: Terrain, radius: float) -> float:
    """Return the highest elevation within `radius` m of where the robot starts, in m."""
    elevations = tile(terrain)
    along = np.abs(np.linspace(-TILE / 2, TILE / 2, CELLS + 1))
    # Whole cells: the surface inside a cell is no higher than its corners.
    near = along <= radius + TILE / CELLS
    return float(terrain.height * elevations[np.ix_(near, near)].max())


def rms_slope(field: NDArray[np.float64], height: float) -> float:
    """Return the root-mean-square slope of a periodic tile along its axes (dimensionless)."""
    return float(height * np.sqrt(np.mean(np.square(_steps(field)))))


def half_correlation(field: NDArray[np.float64]) -> float:
    """Return the distance at which a periodic tile's autocorrelation falls to one half, in m."""
    spectrum = np.abs(np.fft.fft2(field - field.mean())) ** 2
    correlation = np.fft.ifft2(spectrum).real
    along = (correlation[0] + correlation[:, 0]) / (2 * correlation[0, 0])
    after = int(np.argmax(along < 0.5))
    share = (along[after - 1] - 0.5) / (along[after - 1] - along[after])
    return float((after - 1 + share) * TILE / CELLS)


def _mixed(terrain: Terrain, waves: int) -> NDArray[np.float64]:
    """Return the tile of coarse and fine noise whose slope comes nearest to the terrain's."""
    coarse, fine = _perlin(waves, terrain.seed), _perlin(FINER * waves, terrain.seed)
    shares = np.linspace(0.0, 1.0, 201)
    # Squares of a mixture are quadratic in the share, so no mixture needs to be made to measure it.
    variance = _mixture(shares, (1.0, float(np.mean(coarse * fine)), 1.0))
    steep, steeper = _steps(coarse), _steps(fine)
    squares = [float(np.mean(a * b)) for a, b in ((steep, steep), (steep, steeper), (steeper,) * 2)]
    slope = terrain.height * terrain.deviation * np.sqrt(_mixture(shares, squares) / variance)
    share = shares[np.argmin(np.abs(slope - terrain.slope))]
    field = (1 - share) * coarse + share * fine
    return np.asarray(np.clip(terrain.mean + terrain.deviation * field / field.std(), 0.0, 1.0))


def _mixture(shares: NDArray[np.float64], squares: Sequence[float]) -> NDArray[np.float64]:
    first, cross, second = squares
    return (1 - shares) ** 2 * first + 2 * shares * (1 - shares) * cross + shares**2 * second


def _misfit(field: NDArray[np.float64], terrain: Terrain) -> float:
    return abs(math.log(rms_slope(field, terrain.height) / terrain.slope)) + abs(
        math.log(half_correlation(field) / terrain.half_correlation)
    )


def _steps(field: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rise per metre along both axes of a periodic tile (2, rows, columns)."""
    rises = [np.diff(field, axis=axis, append=field.take([0], axis)) for axis in (0, 1)]
    return np.stack(rises) / (TILE / CELLS)


def _perlin(waves: int, seed: int) -> NDArray[np.float64]:
    """Return periodic gradient noise with `waves` lattice cells a side: mean 0, deviation 1."""
    angles = np.random.default_rng([seed, waves]).uniform(0.0, 2 * np.pi, (waves, waves))
    position = np.arange(CELLS) * waves / CELLS
    cell = position.astype(int)
    offset = position - cell
    fade = offset**3 * (offset * (6 * offset - 15) + 10)

    def corner(row: int, column: int) -> NDArray[np.float64]:
        angle = angles[np.ix_((cell + row) % waves, (cell + column) % waves)]
        rise = np.cos(angle) * (offset - column)[None, :] + np.sin(angle) * (offset - row)[:, None]
        across = fade if column else 1 - fade
        down = fade if row else 1 - fade
        return np.asarray(rise * across[None, :] * down[:, None])

    noise = corner(0, 0) + corner(0, 1) + corner(1, 0) + corner(1, 1)
    noise -= noise.mean()
    return np.asarray(noise / noise.std())
