"""Measures of rest poses that say whether a morphology can stand and walk at all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RestPose:
    """The limbs of n morphologies at rest, p limbs each. Lengths are in m.

    Attributes:
        ends: both ends of each limb in the world, (n, p, 2, 3); the same point twice for a ball.
        radii: radius of each limb, (n, p).
        roots: point where each leg leaves the torso, (n, l, 3).
        legs: the limbs of each leg from the torso outwards, as indices into p.
        axes: axis of each hinge, (h, 3).
        swung: the limb that each hinge moves, as an index into p.
    """

    ends: Array
    radii: Array
    roots: Array
    legs: tuple[tuple[int, ...], ...]
    axes: Array
    swung: tuple[int, ...]

    @property
    def lengths(self) -> Array:
        """Length of each limb without its rounded ends, (n, p)."""
        lengths: Array = np.linalg.norm(self.ends[:, :, 0] - self.ends[:, :, 1], axis=-1)
        return lengths

    @property
    def centre(self) -> Array:
        """Centre of volume, (n, 3)."""
        volume = np.pi * self.radii**2 * (self.lengths + 4 / 3 * self.radii)
        middles = self.ends.mean(axis=2)
        centre: Array = (volume[..., None] * middles).sum(1) / volume.sum(1)[:, None]
        return centre

    @property
    def reach(self) -> Array:
        """Largest extent along any axis, (n,)."""
        low, high = self.ends.min(axis=(1, 2)), self.ends.max(axis=(1, 2))
        reach: Array = (high - low).max(axis=1)
        return reach

    @property
    def stride(self) -> Array:
        """Length in m of a leg's limbs from its first hinge on, mean over legs, (n,).

        Without legs it is the reach.
        """
        legs = [[limb for limb in leg if limb >= min(self.swung)] for leg in self.legs]
        if not any(legs):
            return self.reach
        stride: Array = np.mean([self.lengths[:, leg].sum(axis=1) for leg in legs if leg], axis=0)
        return stride

    @property
    def height(self) -> Array:
        """Difference between the lowest and the highest limb end, (n,)."""
        heights = self.ends[..., 2].reshape(len(self.radii), -1)
        height: Array = heights.max(axis=1) - heights.min(axis=1)
        return height

    @property
    def drop(self) -> Array:
        """Height of the lowest limb end above the ground, over the height of the robot, (n,)."""
        lowest = self.ends[..., 2].min(axis=(1, 2))
        drop: Array = np.maximum(lowest, 0) / np.maximum(self.height, 1e-6)
        return drop

    @property
    def overhang(self) -> Array:
        """Distance in x from the centre to the feet, 0 if it is above them, over the height, (n,).

        Feet are the limb ends within a tenth of the height above the ground. A flat morphology has
        no overhang, because all of its limb ends are feet.
        """
        x, z = (self.ends[..., axis].reshape(len(self.radii), -1) for axis in (0, 2))
        lowest = z.min(axis=1, keepdims=True)
        feet = z <= lowest + 0.1 * self.height[:, None] + 1e-9
        back = np.where(feet, x, np.inf).min(axis=1)
        front = np.where(feet, x, -np.inf).max(axis=1)
        centre = self.centre[:, 0]
        outside = np.maximum(np.maximum(back - centre, centre - front), 0)
        overhang: Array = outside / np.maximum(self.height, 1e-6)
        return overhang

    @property
    def folding(self) -> Array:
        """Length of a leg along its limbs over the distance between its ends, mean over legs, (n,).

        A straight leg has 1.
        """
        if not self.legs:
            return np.ones(len(self.radii))
        ratios = []
        for index, leg in enumerate(self.legs):
            spans = np.linalg.norm(self.ends[:, leg[-1]] - self.roots[:, index, None], axis=-1)
            along = self.lengths[:, leg].sum(axis=1)
            ratios.append(along / np.maximum(spans.max(axis=1), 1e-6))
        folding: Array = np.mean(ratios, axis=0)
        return folding

    @property
    def leverage(self) -> Array:
        """Sine of the angle between a hinge and the limb it moves, geometric mean, (n,).

        A limb along its hinge only turns about itself and has 0.
        """
        if not self.swung:
            return np.ones(len(self.radii))
        limbs = self.ends[:, self.swung, 1] - self.ends[:, self.swung, 0]
        across = np.linalg.norm(np.cross(limbs, self.axes), axis=-1)
        size = np.linalg.norm(limbs, axis=-1) * np.linalg.norm(self.axes, axis=-1)
        sines = across / np.maximum(size, 1e-9)
        means: Array = np.exp(np.log(np.maximum(sines, 1e-3)).mean(axis=1))
        return means

    @property
    def tilt(self) -> Array:
        """Height difference between the lowest ends before and behind the centre, over the height,
        (n,)."""
        x, z = (self.ends[..., axis].reshape(len(self.radii), -1) for axis in (0, 2))
        ahead = x >= self.centre[:, :1]
        front = np.where(ahead, z, np.inf).min(axis=1)
        back = np.where(~ahead, z, np.inf).min(axis=1)
        both = ahead.any(axis=1) & (~ahead).any(axis=1)
        difference = np.abs(np.where(both, front, 0) - np.where(both, back, 0))
        tilt: Array = difference / np.maximum(self.height, 1e-6)
        return tilt
