"""What makes a body worth training before anything is known of it: a prior over bodies.

All measures are general: they read a body's solids and its rest pose, and know no task and no
official robot. They are in units of log efficiency: 1 less is expected to be 2.7 times worse.
"""

from __future__ import annotations

import logging
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from robomore.designers.offline.batched_kinematics import Skeleton
from robomore.designers.offline.rest_pose import Pose
from robomore.designers.offline.space import UnitSpace
from robomore.tasks.task import Task

log = logging.getLogger(__name__)

Array = NDArray[np.float64]

LIGHTNESS = 0.7
"""Log efficiency gained by a body of 1/e the volume. Were it as fast, it would gain 1; but light
and thin bodies learn later, so only part of that is believed."""

STRIDE = 1.5
"""Log efficiency gained by legs of e times the length, up to LONG[0]: they make longer strides."""

LONG = (1.0, 1.6)
"""Length of a leg's moving limbs in m from which a robot gains nothing, and from which it loses:
motors of fixed strength swing long legs slowly."""

SLENDER = (1.5, 50.0)
"""Length over radius of a limb: balls below, needles that nothing steadies above."""

UNEVEN_LENGTHS, UNEVEN_RADII = 0.5, 0.4
"""Standard deviation of the log over a body's limbs that is still called proportionate."""

EDGE = 0.2
"""Share of a radius's range, from its lower bound, that is approached with suspicion: the thinnest
limbs weigh next to nothing, and what weighs nothing is flung about by motors of fixed strength."""

FOLDED = 1.5
"""Length of a leg along its limbs over its span that is still called straight enough to stride."""

LOW = 0.3
"""Height over reach below which a body that stands at all is said to lie on its belly."""


class Prior:
    """Judges bodies of one task without simulating them."""

    def __init__(self, task: Task) -> None:
        self._task = task
        self._space = UnitSpace(task)
        try:
            self._skeleton: Skeleton | None = Skeleton(task.template, task.constants)
        except ValueError as error:
            # A robot of a third party may be written in ways whose pose is not read here; its
            # bodies are then judged by their solids alone.
            log.info("%s: bodies are judged without their rest pose: %s", task.id, error)
            self._skeleton = None

    def expected(self, bodies: Array) -> Array:
        """Return the log efficiency expected of valid `bodies` (n, size), less a constant, (n,)."""
        lengths, radii, volumes = self._solids(bodies)
        merit = -LIGHTNESS * np.log(volumes) - self._oddity_of_solids(bodies, lengths, radii)
        if (pose := self._pose(bodies)) is not None:
            merit += STRIDE * np.log(np.clip(pose.stride, 0.01, LONG[0])) - _oddity_of_pose(pose)
        return merit

    def oddity(self, bodies: Array) -> Array:
        """Return how much of log efficiency the shape of valid `bodies` (n, size) costs, (n,) >= 0.

        Volume and size are no part of it.
        """
        lengths, radii, _ = self._solids(bodies)
        odd = self._oddity_of_solids(bodies, lengths, radii)
        if (pose := self._pose(bodies)) is not None:
            odd += _oddity_of_pose(pose)
        return odd

    @cached_property
    def thickness(self) -> NDArray[np.bool_]:
        """Return which parameters set a solid's radius, (size,): found by nudging each."""
        centre = np.full(self._space.size, 0.5)
        nudged = centre + 0.01 * np.eye(self._space.size)
        base, *others = self._space.values(np.vstack((centre, nudged)))
        return np.array([self._radii(base) != self._radii(other) for other in others])

    def _pose(self, bodies: Array) -> Pose | None:
        if self._skeleton is None:
            return None
        columns = dict(zip(self._task.names, np.asarray(bodies, dtype=float).T, strict=True))
        return self._skeleton.pose(columns)

    def _radii(self, body: Array) -> list[float]:
        values = dict(zip(self._task.names, body.tolist(), strict=True))
        return [shape.radius for shape in self._task.shapes(values)]

    def _solids(self, bodies: Array) -> tuple[Array, Array, Array]:
        """Return lengths (n, p) in m, 0 for balls, radii (n, p) in m and volumes (n,) in m^3."""
        names = self._task.names
        robots = [
            self._task.shapes(dict(zip(names, body, strict=True)))
            for body in np.asarray(bodies, dtype=float).tolist()
        ]
        lengths = [[getattr(shape, "length", 0.0) for shape in shapes] for shapes in robots]
        radii = [[shape.radius for shape in shapes] for shapes in robots]
        volumes = [sum(shape.volume for shape in shapes) for shapes in robots]
        return np.array(lengths), np.array(radii), np.array(volumes)

    def _oddity_of_solids(self, bodies: Array, lengths: Array, radii: Array) -> Array:
        thin = np.maximum(EDGE - self._space.units(bodies)[:, self.thickness], 0) / EDGE
        odd: Array = 2 * thin.sum(axis=1) / max(thin.shape[1], 1)
        odd += 2 * np.maximum(np.log(radii).std(axis=1) - UNEVEN_RADII, 0)
        limbs = (lengths > 0).all(axis=0)
        if limbs.any():
            lengths, radii = lengths[:, limbs], radii[:, limbs]
            odd += _outside(lengths / radii, *SLENDER).mean(axis=1)
            odd += 2 * np.maximum(np.log(lengths).std(axis=1) - UNEVEN_LENGTHS, 0)
        return odd


def _oddity_of_pose(pose: Pose) -> Array:
    stands = pose.height > 1e-6
    lies = np.maximum(LOW - pose.height / pose.reach, 0) / LOW
    oddity: Array = (
        STRIDE * np.maximum(np.log(pose.stride / LONG[1]), 0)
        - 2 * np.log(pose.leverage)
        + 4 * np.minimum(pose.overhang, 1)
        + 3 * np.minimum(pose.tilt, 1)
        + 3 * np.maximum(np.log(pose.folding / FOLDED), 0)
        + np.where(stands, 2 * lies, 0)
    )
    return oddity


def _outside(values: Array, low: float, high: float) -> Array:
    """Return by how many e-folds `values` lie outside [low, high]."""
    logs = np.log(np.maximum(values, 1e-9))
    excess: Array = np.maximum(np.log(low) - logs, 0) + np.maximum(logs - np.log(high), 0)
    return excess
